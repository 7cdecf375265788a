/* Light on tubes: key lamp with shadow and gloss, sky and ground, rim lamp, dark halo behind tubes in front.
 */
#include "render/shade.h"

static const double key_light[3] = {0.86, 0.83, 0.77};
static const double sky_light[3] = {0.50, 0.54, 0.60};
static const double ground_light[3] = {0.24, 0.22, 0.20};
static const double rim_light[3] = {0.30, 0.33, 0.38};
/* A stripe covers the quarter of the tube around the first director: cosine of 45 degrees. */
#define STRIPE_COS 0.7071067811865476

/* Smooth step from 0 at 0 to 1 at 1. */
static double smooth(double x) {
  x = x < 0 ? 0 : x > 1 ? 1 : x;
  return x * x * (3 - 2 * x);
}

/* Mostly from above, where the eye expects a lamp. */
hb_v3 hb_key_light(const hb_lens *lens) {
  hb_v3 key = hb_v3_scale(1.0, lens->up);
  key = hb_v3_axpy(key, -0.55, (hb_v3){1, 0, 0});
  key = hb_v3_axpy(key, -0.55, (hb_v3){0, 0, 1});
  double n = hb_v3_norm(key);
  return n > 0.1 ? hb_v3_scale(1 / n, key) : lens->up;
}

/* The rim lamp is behind the tubes, to the right and above. */
void hb_shading_make(hb_shading *s) {
  s->key = hb_key_light(s->lens);
  hb_v3 rim = hb_v3_add(hb_v3_scale(0.5, s->lens->up), (hb_v3){0.7, 0, 0.8});
  s->rim = hb_v3_unit(rim);
}

/* Share of the sky, or of the lamp, at a place around a node: between the angles at which it is known. */
static double around(const hb_occlusion *o, double (*at)(const hb_occlusion *, int, int), int node,
                     double place) {
  int a = (int)place, b = a + 1 < HB_AROUND ? a + 1 : 0;
  double f = place - a, va = at(o, node, a), vb = at(o, node, b);
  return va + f * (vb - va);
}

/* A surface point with what the tables say about it. */
typedef struct surface {
  hb_v3 n, ray;
  double along; /* fraction of the piece */
  double sun, sky;
  double stripe; /* 0..1 */
} surface;

/* Normal of the smooth tube at the point p of a piece: ends of a strand stay round. */
static hb_v3 normal(const hb_piece *piece, const hb_node *a, const hb_node *b, hb_v3 p, double *along) {
  hb_v3 d = hb_v3_sub(p, piece->a);
  double raw = piece->bb > 0 ? hb_v3_dot(d, piece->ab) / piece->bb : 0, s = raw < 0 ? 0 : raw > 1 ? 1 : raw;
  *along = s;
  hb_v3 n = hb_v3_axpy(d, -s, piece->ab);
  if ((raw < 0 && a->first) || (raw > 1 && b->last)) return hb_v3_unit(n);
  hb_v3 t = hb_v3_axpy(hb_v3_scale(1 - s, a->t), s, b->t);
  double tt = hb_v3_dot(t, t);
  if (tt > 0) n = hb_v3_axpy(n, -hb_v3_dot(n, t) / tt, t);
  return hb_v3_unit(n);
}

/* Everything about the surface under a sample. */
static void meet(const hb_shading *sh, int index, double t, const double at[2], surface *out) {
  const hb_piece *piece = &sh->pieces->piece[index];
  const hb_node *a = &sh->strands->node[piece->node], *b = a + 1;
  hb_v3 origin;
  hb_lens_ray(sh->lens, at[0], at[1], &origin, &out->ray);
  hb_v3 p = hb_v3_axpy(origin, t, out->ray);
  out->ray = hb_v3_unit(out->ray);
  out->n = normal(piece, a, b, p, &out->along);
  double s = out->along;
  hb_v3 va = hb_v3_cross(a->t, a->u), vb = hb_v3_cross(b->t, b->u);
  double pa = hb_around(hb_v3_dot(out->n, a->u), hb_v3_dot(out->n, va));
  double pb = hb_around(hb_v3_dot(out->n, b->u), hb_v3_dot(out->n, vb));
  const hb_occlusion *o = sh->occlusion;
  out->sky = (1 - s) * around(o, hb_occlusion_node_sky, piece->node, pa) +
             s * around(o, hb_occlusion_node_sky, piece->node + 1, pb);
  out->sun = (1 - s) * around(o, hb_occlusion_node_sun, piece->node, pa) +
             s * around(o, hb_occlusion_node_sun, piece->node + 1, pb);
  /* The tables hold for the sides; round ends see more of the sky, and of the lamp where they face it. */
  double end = fabs(hb_v3_dot(out->n, a->t));
  if (end > 0.1) {
    end = fmin(end * 1.5, 1);
    out->sky += end * (1 - out->sky);
    out->sun += end * (1 - out->sun);
  }
  out->stripe = 0;
  hb_v3 m = hb_v3_axpy(hb_v3_scale(1 - s, a->m), s, b->m);
  double mm = hb_v3_norm(m);
  if (mm > 0.1) {
    double blur = fmin(fmax(0.35 / piece->edge, 0.01), 0.3);
    out->stripe = smooth(0.5 + 0.5 * (hb_v3_dot(out->n, m) / mm - STRIPE_COS) / blur);
  }
}

/* x to the power 2^k. */
static double power2(double x, int k) {
  for (; k > 0; k--) x *= x;
  return x;
}

/* Light from a tube that is too thin to show its round surface: what all the normals around it reflect
 * together depends on its direction alone, with a bright band across a lock of hair (Kajiya and Kay 1989,
 * sections 4.2 and 4.3: diffuse by the sine of the angle to the lamp, gloss by that to the half-way
 * direction). */
static void shade_hair(const hb_shading *sh, const hb_piece *piece, double depth, const double at[2],
                       double light[3]) {
  const hb_node *a = &sh->strands->node[piece->node], *b = a + 1;
  const hb_look *look = &sh->strands->look[a->tube];
  hb_v3 origin, ray;
  double sun, sky;
  hb_lens_ray(sh->lens, at[0], at[1], &origin, &ray);
  hb_v3 p = hb_v3_axpy(origin, depth, ray), d = hb_v3_sub(p, piece->a);
  double s = piece->bb > 0 ? hb_v3_dot(d, piece->ab) / piece->bb : 0;
  s = s < 0 ? 0 : s > 1 ? 1 : s;
  hb_v3 t = hb_v3_unit(hb_v3_axpy(hb_v3_scale(1 - s, a->t), s, b->t));
  hb_v3 half = hb_v3_unit(hb_v3_sub(sh->key, hb_v3_unit(ray)));
  hb_thicket_light(sh->thicket, p, &sun, &sky);
  double along = hb_v3_dot(t, sh->key), cross = hb_v3_dot(t, half), up = hb_v3_dot(t, sh->lens->up);
  double diffuse = sqrt(fmax(0, 1 - along * along)), gloss = power2(fmax(0, 1 - cross * cross), 4);
  double sheen = power2(fmax(0, 1 - cross * cross), 2), hemisphere = 0.5 + 0.35 * sqrt(fmax(0, 1 - up * up));
  for (int c = 0; c < 3; c++) {
    double ambient = ground_light[c] + hemisphere * (sky_light[c] - ground_light[c]);
    light[c] = look->base[c] * ((0.75 * diffuse + 0.5 * sheen) * sun * key_light[c] + ambient * sky) +
               0.16 * gloss * sun * key_light[c];
  }
}

/* Adds up the lamps. */
void hb_shade_sample(const hb_shading *sh, const hb_tile *tile, int k, double x, double y, double light[3]) {
  surface s;
  const double at[2] = {x, y};
  const hb_piece *piece = &sh->pieces->piece[tile->piece[k]];
  if (sh->thicket) {
    shade_hair(sh, piece, tile->depth[k], at, light);
    return;
  }
  meet(sh, tile->piece[k], tile->depth[k], at, &s);
  const hb_look *look = &sh->strands->look[sh->strands->node[piece->node].tube];
  double facing = -hb_v3_dot(s.n, s.ray);
  if (facing < 0) facing = 0;
  double key = (hb_v3_dot(s.n, sh->key) + 0.12) / 1.12;
  key = key > 0 ? key * s.sun : 0;
  double hemisphere = 0.5 + 0.5 * hb_v3_dot(s.n, sh->lens->up);
  hb_v3 half = hb_v3_unit(hb_v3_sub(sh->key, s.ray));
  double gloss = hb_v3_dot(s.n, half);
  gloss = gloss > 0 ? gloss : 0;
  for (int i = 0; i < 5; i++) gloss *= gloss; /* to the power 32 */
  double edge = 1 - facing, edge3 = edge * edge * edge;
  double rim = hb_v3_dot(s.n, sh->rim);
  rim = rim > 0 ? rim * edge3 : 0;
  double halo = 1 - 0.5 * (double)tile->halo[k], contour = 1 - 0.45 * edge3 * edge;
  for (int c = 0; c < 3; c++) {
    double albedo = look->base[c] + s.stripe * (look->stripe[c] - look->base[c]);
    double ambient = ground_light[c] + hemisphere * (sky_light[c] - ground_light[c]);
    double v = albedo * (key * key_light[c] + ambient * s.sky) + 0.22 * gloss * s.sun * key_light[c];
    light[c] = (v * contour + rim * rim_light[c] * s.sky) * halo;
  }
}
