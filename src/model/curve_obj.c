#include "base/memory.h"
#include "model/curve_file.h"
#include "model/curve_parts.h"
#include "model/formula_number.h"

#include <string.h>

/* A piece of an `l` statement: two vertices, from 0, and the line of the file. */
typedef struct edge {
  int from, to, line;
} edge;

/* What an OBJ file has given so far. */
typedef struct object {
  hb_points vertices;
  edge *edges;
  int count, room;
} object;

/* v x y z, more numbers (weight, colour) are passed over. */
static hb_status read_vertex(const hb_lines *lines, size_t at, object *o, hb_error *err) {
  double p[3];
  for (int k = 0; k < 3; k++) {
    size_t from, length;
    if (!hb_lines_word(lines, &at, &from, &length))
      return hb_lines_fail(lines, err, "a vertex has three numbers, found %d", k);
    if (!hb_number_field(lines->line + from, length, &p[k]))
      return hb_lines_fail(lines, err,
                           "coordinate %d of the vertex is '%.*s', allowed are finite decimal numbers", k + 1,
                           length > 40 ? 40 : (int)length, lines->line + from);
  }
  return hb_points_add(&o->vertices, p, err);
}

/* Index in a word such as 12, -1 or 12/7, as a vertex from 0. */
static hb_status read_index(const hb_lines *lines, const char *word, size_t length, int vertices, int *out,
                            hb_error *err) {
  const char *slash = memchr(word, '/', length);
  size_t end = slash ? (size_t)(slash - word) : length, at = word[0] == '-' ? 1 : 0;
  long value = 0;
  bool sound = end > at;
  for (; sound && at < end; at++) {
    sound = word[at] >= '0' && word[at] <= '9' && value <= HB_CURVE_COUNT_MAX;
    if (sound) value = 10 * value + (word[at] - '0');
  }
  long vertex = word[0] == '-' ? vertices - value : value - 1;
  if (sound && value > 0 && vertex >= 0 && vertex < vertices) {
    *out = (int)vertex;
    return HB_OK;
  }
  return hb_lines_fail(lines, err, "'%.*s' is no vertex; allowed are 1 to %d, or -1 to -%d from the end",
                       length > 40 ? 40 : (int)length, word, vertices, vertices);
}

/* One more piece of the polyline. */
static hb_status add_edge(object *o, edge e, hb_error *err) {
  if (o->count == o->room) {
    int room = o->room ? 2 * o->room : 64;
    edge *grown = hb_realloc(o->edges, (size_t)room, sizeof *grown);
    if (!grown) return hb_fail_memory(err, "the lines of a curve file");
    o->edges = grown;
    o->room = room;
  }
  o->edges[o->count++] = e;
  return HB_OK;
}

/* l i j k ... */
static hb_status read_line(const hb_lines *lines, size_t at, object *o, hb_error *err) {
  int last = -1, found = 0;
  size_t from, length;
  while (hb_lines_word(lines, &at, &from, &length)) {
    int vertex = 0;
    hb_status status = read_index(lines, lines->line + from, length, o->vertices.count, &vertex, err);
    if (status != HB_OK) return status;
    if (vertex == last) return hb_lines_fail(lines, err, "vertex %d follows itself in a line", vertex + 1);
    if (last >= 0) status = add_edge(o, (edge){last, vertex, lines->number}, err);
    if (status != HB_OK) return status;
    last = vertex;
    found++;
  }
  if (found < 2) return hb_lines_fail(lines, err, "a line joins at least 2 vertices, found %d", found);
  return HB_OK;
}

/* Cuts off comments and joins lines that end in a backslash, in place: the blanked bytes keep the line
 * numbers. */
static void prepare(hb_lines *lines) {
  bool comment = false;
  for (size_t k = 0; k < lines->length; k++) {
    char *c = lines->text + k;
    if (*c == '\n' || *c == '\r') {
      comment = false;
    } else if (comment || *c == '#') {
      comment = true;
      *c = ' ';
    }
  }
}

/* Appends the next line to the present one if that ends in a backslash. */
static void join(hb_lines *lines) {
  while (lines->line_length > 0 && lines->line[lines->line_length - 1] == '\\') {
    char *start = lines->line;
    size_t mark = (size_t)(start - lines->text) + lines->line_length - 1;
    if (!hb_lines_next(lines)) {
      lines->line = start;
      lines->line_length = mark - (size_t)(start - lines->text);
      return;
    }
    size_t end = (size_t)(lines->line - lines->text) + lines->line_length;
    for (char *c = lines->text + mark; c < lines->line; c++) *c = ' ';
    lines->line = start;
    lines->line_length = end - (size_t)(start - lines->text);
  }
}

/* All statements; those that are neither v nor l are passed over. */
static hb_status read_statements(hb_lines *lines, object *o, hb_error *err) {
  prepare(lines);
  while (hb_lines_next(lines)) {
    size_t at = 0, from, length;
    join(lines);
    if (!hb_lines_word(lines, &at, &from, &length) || length != 1) continue;
    hb_status status = HB_OK;
    if (lines->line[from] == 'v') status = read_vertex(lines, at, o, err);
    if (lines->line[from] == 'l') status = read_line(lines, at, o, err);
    if (status != HB_OK) return status;
  }
  return HB_OK;
}

/* True if every piece begins where the one before ends. */
static bool in_order(const object *o) {
  for (int k = 1; k < o->count; k++)
    if (o->edges[k].from != o->edges[k - 1].to) return false;
  return true;
}

/* Puts the two pieces at each vertex into touch (2 per vertex, -1: none). A third is an error. */
static hb_status link_edges(const object *o, const char *path, int *touch, hb_error *err) {
  for (int k = 0; k < 2 * o->vertices.count; k++) touch[k] = -1;
  for (int k = 0; k < o->count; k++) {
    int ends[2] = {o->edges[k].from, o->edges[k].to};
    for (int j = 0; j < 2; j++) {
      int *slot = touch + 2 * ends[j];
      if (slot[0] >= 0 && slot[1] >= 0)
        return hb_fail(err, HB_ERR_INPUT,
                       "%s:%d: vertex %d joins more than two pieces, a curve has no branches", path,
                       o->edges[k].line, ends[j] + 1);
      if (slot[0] < 0)
        slot[0] = k;
      else
        slot[1] = k;
    }
  }
  return HB_OK;
}

/* First end in the file: a vertex with one piece; in a ring the start of the first piece. */
static int first_end(const object *o, const int *touch) {
  for (int k = 0; k < o->count; k++) {
    if (touch[2 * o->edges[k].from + 1] < 0) return o->edges[k].from;
    if (touch[2 * o->edges[k].to + 1] < 0) return o->edges[k].to;
  }
  return o->edges[0].from;
}

/* Walks from piece to piece and writes count + 1 vertices into order. */
static hb_status walk(const object *o, const char *path, const int *touch, int *order, hb_error *err) {
  int vertex = first_end(o, touch), piece = touch[2 * vertex], done = 0;
  order[0] = vertex;
  while (piece >= 0 && done < o->count) {
    vertex = o->edges[piece].from == vertex ? o->edges[piece].to : o->edges[piece].from;
    order[++done] = vertex;
    int next = touch[2 * vertex] == piece ? touch[2 * vertex + 1] : touch[2 * vertex];
    if (vertex == order[0]) break; /* a ring has come round */
    piece = next;
  }
  if (done == o->count) return HB_OK;
  return hb_fail(err, HB_ERR_INPUT,
                 "%s: the lines are not one curve: from vertex %d only %d of %d pieces can be reached", path,
                 order[0] + 1, done, o->count);
}

/* Vertices in the order of the polyline: as written if the pieces follow one another, else by walking. */
static hb_status sort_edges(const object *o, const char *path, int *order, hb_error *err) {
  if (in_order(o)) {
    order[0] = o->edges[0].from;
    for (int k = 0; k < o->count; k++) order[k + 1] = o->edges[k].to;
    return HB_OK;
  }
  int *touch = hb_alloc(2 * (size_t)o->vertices.count, sizeof *touch);
  if (!touch) return hb_fail_memory(err, "the lines of a curve file");
  hb_status status = link_edges(o, path, touch, err);
  if (status == HB_OK) status = walk(o, path, touch, order, err);
  hb_free(touch);
  return status;
}

/* Copies the vertices in the order of the polyline; neighbours that coincide are refused. */
static hb_status arrange(const object *o, const char *path, hb_points *points, hb_error *err) {
  int count = o->count > 0 ? o->count + 1 : o->vertices.count;
  int *order = hb_alloc((size_t)count, sizeof *order);
  if (!order) return hb_fail_memory(err, "the lines of a curve file");
  hb_status status = HB_OK;
  for (int k = 0; k < count; k++) order[k] = k;
  if (o->count > 0) status = sort_edges(o, path, order, err);
  for (int k = 0; k < count && status == HB_OK; k++) {
    const double *p = o->vertices.xyz + 3 * (size_t)order[k];
    const double *last = k > 0 ? o->vertices.xyz + 3 * (size_t)order[k - 1] : NULL;
    if (last && p[0] == last[0] && p[1] == last[1] && p[2] == last[2])
      status = hb_fail(err, HB_ERR_INPUT, "%s: vertices %d and %d of the curve coincide at (%g, %g, %g)",
                       path, order[k - 1] + 1, order[k] + 1, p[0], p[1], p[2]);
    else
      status = hb_points_add(points, p, err);
  }
  hb_free(order);
  return status;
}

/* Statements, then order. */
hb_status hb_obj_read(hb_lines *lines, hb_points *points, hb_error *err) {
  object o = {{NULL, 0, 0}, NULL, 0, 0};
  hb_status status = read_statements(lines, &o, err);
  if (status == HB_OK) status = arrange(&o, lines->path, points, err);
  hb_free(o.vertices.xyz);
  hb_free(o.edges);
  return status;
}
