#include "support/dense.h"

#include "support/near.h"

#include <string.h>

#define N 16 /* vertices at most */

/* Everything that the thesis keeps, for one rod. First indices: edge j or interior vertex k; then vertex i.
 */
typedef struct tensors {
  int nv;
  unsigned misprints;
  double edge[N][3], size[N], tangent[N][3]; /* size: length that the formulas use */
  double m1[N][3], m2[N][3];
  double kb[N][3], chi[N];
  double grad_kb[N][N][3][3]; /* d (kb_k)_a / d (x_i)_b */
  double grad_psi[N][N][3];   /* d psi_k / d x_i */
  double grad_Psi[N][N][3];   /* d Psi^j / d x_i, Psi^j = sum of psi_k, k <= j */
  double omega[N][2][2];      /* of vertex k on edges k-1, k */
  double grad_omega[N][2][N][2][3];
} tensors;

/* a . b */
static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* a x b; out may be one of them. */
static void cross(const double a[3], const double b[3], double out[3]) {
  double c[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  memcpy(out, c, sizeof c);
}

/* out = factor [a] (the matrix of a x) + w b^T. */
static void skew_and_outer(double factor, const double a[3], const double w[3], const double b[3],
                           double out[3][3]) {
  double skew[3][3] = {{0, -a[2], a[1]}, {a[2], 0, -a[0]}, {-a[1], a[0], 0}};
  for (int p = 0; p < 3; p++)
    for (int q = 0; q < 3; q++) out[p][q] = factor * skew[p][q] + w[p] * b[q];
}

/* Edges, lengths, curvature binormals. */
static void geometry(tensors *T, const rod_energy *e, const double *x, dense_lengths lengths) {
  const double *rest = e->def->lengths_from_initial ? e->def->initial : e->def->rest;
  T->nv = e->nv;
  assert_true(e->nv <= N);
  for (int j = 0; j + 1 < e->nv; j++) {
    double r[3];
    for (int c = 0; c < 3; c++) {
      T->edge[j][c] = x[3 * j + 3 + c] - x[3 * j + c];
      r[c] = rest[3 * j + 3 + c] - rest[3 * j + c];
    }
    double now = sqrt(dot(T->edge[j], T->edge[j]));
    T->size[j] = lengths == DENSE_REST ? sqrt(dot(r, r)) : now;
    for (int c = 0; c < 3; c++) T->tangent[j][c] = T->edge[j][c] / now;
  }
  for (int k = 1; k + 1 < e->nv; k++) {
    T->chi[k] = T->size[k - 1] * T->size[k] + dot(T->edge[k - 1], T->edge[k]);
    cross(T->edge[k - 1], T->edge[k], T->kb[k]);
    for (int c = 0; c < 3; c++) T->kb[k][c] *= 2 / T->chi[k];
  }
}

/* Gradients of kb. With lengths that follow the vertices, chi changes by them as well. */
static void curvature_gradients(tensors *T, dense_lengths lengths) {
  for (int k = 1; k + 1 < T->nv; k++) {
    double before[3], after[3];
    for (int c = 0; c < 3; c++) {
      before[c] =
          (T->edge[k][c] + (lengths == DENSE_CURRENT ? T->size[k] * T->tangent[k - 1][c] : 0)) / T->chi[k];
      after[c] = -(T->edge[k - 1][c] + (lengths == DENSE_CURRENT ? T->size[k - 1] * T->tangent[k][c] : 0)) /
                 T->chi[k];
    }
    if (T->misprints & DENSE_E1)
      for (int c = 0; c < 3; c++) after[c] = -after[c];
    skew_and_outer(2 / T->chi[k], T->edge[k], T->kb[k], before, T->grad_kb[k][k - 1]);
    skew_and_outer(2 / T->chi[k], T->edge[k - 1], T->kb[k], after, T->grad_kb[k][k + 1]);
    if (T->misprints & DENSE_P1) { /* the outer products taken out, the scalar ones into every entry */
      double before_dot = dot(T->kb[k], before), after_dot = dot(T->kb[k], after);
      for (int p = 0; p < 3; p++)
        for (int q = 0; q < 3; q++) {
          T->grad_kb[k][k - 1][p][q] += before_dot - T->kb[k][p] * before[q];
          T->grad_kb[k][k + 1][p][q] += after_dot - T->kb[k][p] * after[q];
        }
    }
    for (int p = 0; p < 3; p++)
      for (int q = 0; q < 3; q++)
        T->grad_kb[k][k][p][q] = -T->grad_kb[k][k - 1][p][q] - T->grad_kb[k][k + 1][p][q];
  }
}

/* Gradients of the holonomy and its sums. */
static void holonomy_gradients(tensors *T) {
  for (int k = 1; k + 1 < T->nv; k++)
    for (int c = 0; c < 3; c++) {
      T->grad_psi[k][k - 1][c] = T->kb[k][c] / (2 * T->size[k - 1]);
      T->grad_psi[k][k + 1][c] = -T->kb[k][c] / (2 * T->size[k]);
      T->grad_psi[k][k][c] = -T->grad_psi[k][k - 1][c] - T->grad_psi[k][k + 1][c];
    }
  for (int j = 1; j + 1 < T->nv; j++)
    for (int i = 0; i < T->nv; i++)
      for (int c = 0; c < 3; c++) T->grad_Psi[j][i][c] = T->grad_Psi[j - 1][i][c] + T->grad_psi[j][i][c];
}

/* The sums as the thesis's chapters print them: one vertex too far. */
static void misprint_sums(tensors *T) {
  double right[N][N][3];
  memcpy(right, T->grad_Psi, sizeof right);
  for (int j = 0; j + 2 < T->nv; j++) memcpy(T->grad_Psi[j], right[j + 1], sizeof right[j]);
}

/* Bishop frames by the rotation P_i about kb, then the material frames. */
static void frames(tensors *T, const rod_energy *e) {
  double u[3];
  memcpy(u, e->u0, sizeof u);
  for (int j = 0; j + 1 < T->nv; j++) {
    if (j > 0) { /* (4 - |kb|^2) u + 4 kb x u + 2 kb (kb.u), over 4 + |kb|^2, with kb from unit tangents */
      double q[3], across[3], c = 1 + dot(T->tangent[j - 1], T->tangent[j]);
      cross(T->tangent[j - 1], T->tangent[j], q);
      for (int p = 0; p < 3; p++) q[p] *= 2 / c;
      cross(q, u, across);
      double square = dot(q, q), along = dot(q, u);
      for (int p = 0; p < 3; p++)
        u[p] = ((4 - square) * u[p] + 4 * across[p] + 2 * along * q[p]) / (4 + square);
    }
    double v[3], co = cos(e->theta[j]), si = sin(e->theta[j]);
    cross(T->tangent[j], u, v);
    for (int p = 0; p < 3; p++) {
      T->m1[j][p] = u[p] * co + v[p] * si;
      T->m2[j][p] = -u[p] * si + v[p] * co;
    }
  }
}

/* Material curvatures and their gradients by every vertex: (m2; -m1) grad kb - J omega (grad Psi)^T. */
static void material_gradients(tensors *T) {
  double J = T->misprints & DENSE_P2 ? -1 : 1;
  for (int k = 1; k + 1 < T->nv; k++)
    for (int side = 0; side < 2; side++) {
      int j = k - 1 + side;
      double *w = T->omega[k][side];
      w[0] = dot(T->kb[k], T->m2[j]);
      w[1] = -dot(T->kb[k], T->m1[j]);
      for (int i = 0; i < T->nv; i++)
        for (int c = 0; c < 3; c++) {
          double first = J * w[1] * T->grad_Psi[j][i][c], second = -J * w[0] * T->grad_Psi[j][i][c];
          for (int p = 0; p < 3; p++) {
            first += T->m2[j][p] * T->grad_kb[k][i][p][c];
            second -= T->m1[j][p] * T->grad_kb[k][i][p][c];
          }
          T->grad_omega[k][side][i][0][c] = first;
          T->grad_omega[k][side][i][1][c] = second;
        }
    }
}

/* All quantities in order. */
static void fill(tensors *T, const rod_energy *e, const double *x, dense_lengths lengths,
                 unsigned misprints) {
  memset(T, 0, sizeof *T);
  T->misprints = misprints;
  geometry(T, e, x, lengths);
  curvature_gradients(T, lengths);
  holonomy_gradients(T);
  frames(T, e);
  double sums[N][N][3];
  memcpy(sums, T->grad_Psi, sizeof sums);
  if (misprints & DENSE_E3) misprint_sums(T); /* in grad omega; the term of the last frame has its own sum */
  material_gradients(T);
  memcpy(T->grad_Psi, sums, sizeof sums);
}

/* B^j (omega_k^j - rest). */
static void stress(const tensors *T, const rod_energy *e, int k, int side, double out[2]) {
  const double *B = e->def->B + 3 * (k - 1 + side), *rest = e->rest_omega + 4 * k + 2 * side;
  double a = T->omega[k][side][0] - rest[0], b = T->omega[k][side][1] - rest[1];
  out[0] = B[0] * a + B[1] * b;
  out[1] = B[1] * a + B[2] * b;
}

/* d(W_j + W_{j+1})/dtheta^j + 2 (beta_j m_j/l_j - beta_{j+1} m_{j+1}/l_{j+1}), natural twist taken off. */
static void theta_gradient(const tensors *T, const rod_energy *e, double *gradient) {
  int ne = T->nv - 1;
  for (int j = 0; j < ne; j++) {
    gradient[j] = 0;
    for (int k = j > 0 ? j : 1; k <= j + 1 && k < ne; k++) {
      int side = k == j ? 1 : 0;
      double s[2];
      const double *w = T->omega[k][side];
      stress(T, e, k, side, s);
      gradient[j] += (-w[0] * s[1] + w[1] * s[0]) / e->voronoi[k]; /* omega^T J s, J = ((0,-1),(1,0)) */
      double m = e->theta[k] - e->theta[k - 1] - e->rest_twist[k];
      gradient[j] += (k == j ? 2 : -2) * e->def->beta[k] * m / e->voronoi[k];
    }
  }
}

/* The formula on freshly made quantities. */
void dense_theta_gradient(const rod_energy *e, const double *x, dense_lengths lengths, double *gradient) {
  tensors T;
  fill(&T, e, x, lengths, 0);
  theta_gradient(&T, e, gradient);
}

/* What the misprints make of the last edge's dE/dtheta and of the gradients that go with it. */
static void misprint_end(tensors *T, const rod_energy *e, double *torque) {
  int last = T->nv - 2;
  double s[2], J = T->misprints & DENSE_P2 ? -1 : 1, twist = e->theta[last] - e->theta[last - 1];
  const double *w = T->omega[last][1];
  if (T->misprints & DENSE_P3) twist = e->theta[last] - e->theta[0];
  stress(T, e, last, 1, s);
  *torque = J * (w[1] * s[0] - w[0] * s[1]) / e->voronoi[last] +
            2 * e->def->beta[last] * (twist - e->rest_twist[last]) / e->voronoi[last];
  if (T->misprints & DENSE_P4) memset(T->grad_Psi[last][T->nv - 3], 0, sizeof T->grad_Psi[last][0]);
  if (T->misprints & DENSE_E10)
    for (int c = 0; c < 3; c++)
      T->grad_Psi[last][T->nv - 2][c] += T->grad_psi[last][0][c] - T->grad_psi[last][T->nv - 2][c];
}

/* - dE/dx_i at fixed angles + sum over held edges of dE/dtheta^j grad_i Psi^j. */
static void sum_force(tensors *T, const rod_energy *e, double *force) {
  double gradient[N], s[2], sign = T->misprints & DENSE_E5 ? -1 : 1;
  theta_gradient(T, e, gradient);
  if (T->misprints) misprint_end(T, e, &gradient[T->nv - 2]);
  for (int i = 0; i < T->nv; i++)
    for (int c = 0; c < 3; c++) {
      double sum = 0;
      for (int k = 1; k + 1 < T->nv; k++)
        for (int side = 0; side < 2; side++) {
          stress(T, e, k, side, s);
          for (int a = 0; a < 2; a++) sum -= T->grad_omega[k][side][i][a][c] * s[a] / e->voronoi[k];
        }
      for (int j = 0; j + 1 < T->nv; j++)
        if (e->held[j]) sum += sign * gradient[j] * T->grad_Psi[j][i][c];
      force[3 * i + c] = sum;
    }
}

/* The formula on freshly made quantities. */
void dense_force(const rod_energy *e, const double *x, dense_lengths lengths, double *force) {
  tensors T;
  fill(&T, e, x, lengths, 0);
  sum_force(&T, e, force);
}

/* With rest lengths, as the thesis has them. */
void dense_force_misprinted(const rod_energy *e, const double *x, unsigned misprints, double *force) {
  tensors T;
  fill(&T, e, x, DENSE_REST, misprints);
  sum_force(&T, e, force);
}

/* - sum 2 alpha/l_k (grad_i kb_k)^T kb_k + M sum grad_i psi_k, M = 2 beta (theta^last - theta^first)/sum l.
 */
void dense_force_isotropic(const rod_energy *e, const double *x, dense_lengths lengths, double *force) {
  tensors T;
  double total = 0, moment = 0, alpha = e->def->B[0];
  int last = e->nv - 2;
  fill(&T, e, x, lengths, 0);
  for (int k = 1; k <= last; k++) total += e->voronoi[k];
  if (e->held[0] && e->held[last]) moment = 2 * e->def->beta[1] * (e->theta[last] - e->theta[0]) / total;
  for (int i = 0; i < T.nv; i++)
    for (int c = 0; c < 3; c++) {
      double sum = 0;
      for (int k = 1; k <= last; k++) {
        for (int p = 0; p < 3; p++) sum -= 2 * alpha / e->voronoi[k] * T.grad_kb[k][i][p][c] * T.kb[k][p];
        sum += moment * T.grad_psi[k][i][c];
      }
      force[3 * i + c] = sum;
    }
}

/* Normal equations of the edges' multipliers: tridiagonal, solved from the first edge on. */
void dense_project(int nv, const double *x, double *f) {
  double t[N][3], diagonal[N], right[N], off[N];
  int ne = nv - 1;
  assert_true(nv <= N);
  for (int j = 0; j < ne; j++) {
    double e[3], rate[3];
    for (int c = 0; c < 3; c++) {
      e[c] = x[3 * j + 3 + c] - x[3 * j + c];
      rate[c] = f[3 * j + 3 + c] - f[3 * j + c];
    }
    double length = sqrt(dot(e, e));
    for (int c = 0; c < 3; c++) t[j][c] = e[c] / length;
    diagonal[j] = 2;
    right[j] = dot(t[j], rate);
    off[j] = j > 0 ? -dot(t[j - 1], t[j]) : 0;
    if (j > 0) {
      right[j] -= off[j] / diagonal[j - 1] * right[j - 1];
      diagonal[j] -= off[j] / diagonal[j - 1] * off[j];
    }
  }
  for (int j = ne - 1; j >= 0; j--) {
    right[j] = (right[j] - (j + 1 < ne ? off[j + 1] * right[j + 1] : 0)) / diagonal[j];
    for (int c = 0; c < 3; c++) {
      f[3 * j + 3 + c] -= right[j] * t[j][c];
      f[3 * j + c] += right[j] * t[j][c];
    }
  }
}
