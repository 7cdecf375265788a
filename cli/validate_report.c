/* What was found: a table for the terminal, report.md for people, report.json for programs. */
#include "base/memory.h"
#include "cli/validate.h"
#include "output/file.h"
#include "output/json.h"

#include <math.h>
#include <string.h>

/* Ways to write a number. */
typedef enum style { WHOLE, ERROR, SIGNED, TOLERANCE, ORDER } style;

/* A number with as many digits as one reads; "-" if there is none. */
static const char *digits(double value, style how, char text[32]) {
  if (isnan(value))
    snprintf(text, 32, "-");
  else if (how == WHOLE)
    snprintf(text, 32, "%.13g", value);
  else if (how == TOLERANCE)
    snprintf(text, 32, "%.2g", value);
  else if (how == ORDER)
    snprintf(text, 32, "%.3f", value);
  else
    snprintf(text, 32, how == SIGNED ? "%+.1e" : "%.1e", value);
  return text;
}

/* "id name". */
static void case_name(const cli_case *c, char *text, size_t size) {
  snprintf(text, size, "%s%s%s", c->id ? c->id : "", c->id ? " " : "", c->name);
}

/* How many points and cases. */
typedef struct counts {
  int cases, failed, not_yet, numbers, wrong;
} counts;

/* Counts everything. */
static counts count(const cli_validation *v) {
  counts n = {0, 0, 0, v->verdict_count, 0};
  for (int k = 0; k < v->case_count; k++) {
    bool listed = v->cases[k]->deed == CLI_NOT_YET;
    n.not_yet += listed;
    n.cases += !listed;
    n.failed += !listed && !cli_case_holds(v, v->cases[k]);
  }
  for (int k = 0; k < v->verdict_count; k++) n.wrong += !v->verdicts[k].good;
  return n;
}

/* The first sentence of a point of the verdict's column that went wrong. */
static const char *sentence(const cli_validation *v, const cli_verdict *verdict) {
  if (verdict->why && verdict->why[0]) return verdict->why;
  const cli_case *c = verdict->of;
  const cli_point *points = cli_case_points(v, c);
  for (int m = 0; m < c->mesh_count; m++)
    if (points[verdict->variant * c->mesh_count + m].err.status)
      return points[verdict->variant * c->mesh_count + m].err.text;
  return points[0].err.status ? points[0].err.text : "";
}

/* One line per verdict. */
static void print_verdict(const cli_validation *v, const cli_verdict *verdict, FILE *to) {
  char label[200], name[300], a[32], b[32], c[32], d[32], e[32];
  cli_case_label(verdict->of, verdict->variant, label, sizeof label);
  snprintf(name, sizeof name, "%s%s%s%s", verdict->expect->name, label[0] ? " (" : "", label,
           label[0] ? ")" : "");
  fprintf(to, "  %-4s %-44.100s expected %-17s found %-17s error %-9s of %-7s%s %s\n",
          verdict->good ? "ok" : "FAIL", name, digits(verdict->expected, WHOLE, a),
          digits(verdict->found, WHOLE, b), digits(verdict->error, ERROR, c),
          digits(verdict->tolerance, TOLERANCE, d), verdict->expect->order > 0 ? " order" : "",
          verdict->expect->order > 0 ? digits(verdict->order, ORDER, e) : "");
  if (!verdict->good) fprintf(to, "       %s\n", sentence(v, verdict));
}

/* The table. */
void cli_validation_print(const cli_validation *v, FILE *to, bool failures) {
  char name[100];
  counts n = count(v);
  for (int k = 0; k < v->case_count; k++) {
    const cli_case *c = v->cases[k];
    bool holds = cli_case_holds(v, c);
    if (failures && holds) continue;
    case_name(c, name, sizeof name);
    fprintf(to, "%s: %s%s%s\n", name, c->title, c->deed == CLI_NOT_YET ? " - not yet: " : "",
            c->deed == CLI_NOT_YET ? c->not_yet : "");
    for (int i = 0; i < v->verdict_count; i++)
      if (v->verdicts[i].of == c && !(failures && v->verdicts[i].good)) print_verdict(v, &v->verdicts[i], to);
  }
  fprintf(to, "%d of %d cases hold (%d of %d numbers), %d not yet; %.1f s with %d thread%s\n",
          n.cases - n.failed, n.cases, n.numbers - n.wrong, n.numbers, n.not_yet, v->seconds, v->threads,
          v->threads > 1 ? "s" : "");
}

/* Text in a cell of a table: no bars, no line breaks. */
static void put_cell(FILE *to, const char *text) {
  for (; text && *text; text++) fputc(*text == '|' || (unsigned char)*text < 32 ? ' ' : *text, to);
}

/* The verdict of a case that is closest to its tolerance, or beyond; NULL if there is none. */
static const cli_verdict *worst(const cli_validation *v, const cli_case *c) {
  const cli_verdict *found = NULL;
  for (int k = 0; k < v->verdict_count; k++) {
    const cli_verdict *now = &v->verdicts[k];
    if (now->of != c) continue;
    if (!found || (found->good && (!now->good || now->share > found->share))) found = now;
  }
  return found;
}

/* One line per case. */
static void write_overview(const cli_validation *v, FILE *to) {
  fprintf(to, "| case | what | how | numbers | closest to its tolerance | error | tolerance | order | |\n"
              "|---|---|---|---|---|---|---|---|---|\n");
  for (int k = 0; k < v->case_count; k++) {
    const cli_case *c = v->cases[k];
    const cli_verdict *w = worst(v, c);
    char a[32], b[32], d[32];
    if (c->deed == CLI_NOT_YET) continue;
    fprintf(to, "| [%s%s%s](#%s) | ", c->id ? c->id : "", c->id ? " " : "", c->name, c->name);
    put_cell(to, c->title);
    fprintf(to, " | %s | %d | ", cli_deed_words[c->deed], c->variants * c->expect_count);
    put_cell(to, w->expect->name);
    fprintf(to, " | %s | %s | %s | %s |\n", digits(w->error, ERROR, a), digits(w->tolerance, TOLERANCE, b),
            digits(w->order, ORDER, d), cli_case_holds(v, c) ? "holds" : "**FAILS**");
  }
}

/* Cases that cannot be computed yet. */
static void write_not_yet(const cli_validation *v, FILE *to) {
  if (count(v).not_yet == 0) return;
  fprintf(to, "\n## Not yet\n\n| case | what | why |\n|---|---|---|\n");
  for (int k = 0; k < v->case_count; k++) {
    const cli_case *c = v->cases[k];
    if (c->deed != CLI_NOT_YET) continue;
    fprintf(to, "| %s %s | ", c->id ? c->id : "", c->name);
    put_cell(to, c->title);
    fprintf(to, " | ");
    put_cell(to, c->not_yet);
    fprintf(to, " |\n");
  }
}

/* Errors on all meshes of a verdict: "-1.2e-03, -3.0e-04". */
static void write_errors(const cli_validation *v, const cli_verdict *verdict, FILE *to) {
  const cli_case *c = verdict->of;
  const cli_point *points = cli_case_points(v, c), *column = points + verdict->variant * c->mesh_count;
  int index = (int)(verdict->expect - c->expects);
  for (int m = 0; m < c->mesh_count; m++) {
    double known = verdict->expect->same ? points[0].found[index] : column[m].expected[index];
    double error = column[m].found[index] - known;
    if (verdict->relative) error /= fabs(known);
    char text[32];
    fprintf(to, "%s%s", m ? ", " : "", column[m].err.status ? "-" : digits(error, SIGNED, text));
  }
}

/* A section per case. */
static void write_case(const cli_validation *v, const cli_case *c, bool plots, FILE *to) {
  fprintf(to, "\n<a id=\"%s\"></a>\n## %s%s%s\n\n%s.\n\n", c->name, c->id ? c->id : "", c->id ? " " : "",
          c->name, c->title);
  if (c->source) fprintf(to, "Source: %s.\n\n", c->source);
  if (c->note) fprintf(to, "%s\n\n", c->note);
  fprintf(to, "Files: `%s`, `%s`. Deed: %s.", c->path, c->scene, cli_deed_words[c->deed]);
  for (int k = 0; c->meshes && k < c->meshes->count; k++) {
    fprintf(to, " Meshes: %s =", c->meshes->children[k]->key);
    for (int m = 0; m < c->mesh_count; m++)
      fprintf(to, "%s %s", m ? "," : "", c->meshes->children[k]->children[m]->text);
    fprintf(to, ".");
  }
  fprintf(to, "\n\n| | quantity | kind | expected | found | tolerance | errors | order | limit |\n"
              "|---|---|---|---|---|---|---|---|---|\n");
  for (int k = 0; k < v->verdict_count; k++) {
    const cli_verdict *w = &v->verdicts[k];
    char label[200], a[32], b[32], d[32], e[32], f[32];
    if (w->of != c) continue;
    cli_case_label(c, w->variant, label, sizeof label);
    fprintf(to, "| %s | ", w->good ? "ok" : "**FAIL**");
    put_cell(to, w->expect->name);
    fprintf(to, "%s%s", label[0] ? ", " : "", label);
    fprintf(to, " | %s | %s | %s | %s %s | ", cli_kind_words[w->expect->kind], digits(w->expected, WHOLE, a),
            digits(w->found, WHOLE, b), digits(w->tolerance, TOLERANCE, d),
            w->relative ? "relative" : "absolute");
    write_errors(v, w, to);
    fprintf(to, " | %s | %s |\n", digits(w->order, ORDER, e), digits(w->limit_error, SIGNED, f));
    if (!w->good) fprintf(to, "| | %s | | | | | | | |\n", sentence(v, w));
  }
  if (plots) fprintf(to, "\n![%s](%s.png)\n", c->title, c->name);
}

/* report.md */
static hb_status write_markdown(const cli_validation *v, const char *path, bool plots, hb_error *err) {
  hb_file file;
  hb_status status = hb_file_begin(path, &file, err);
  if (status) return status;
  counts n = count(v);
  fprintf(
      file.stream,
      "# Known answers\n\nHebra %s. %d of %d cases hold, %d of %d numbers; %d cases not yet. %.1f s with %d "
      "thread%s.\n\n",
      HB_VERSION, n.cases - n.failed, n.cases, n.numbers - n.wrong, n.numbers, n.not_yet, v->seconds,
      v->threads, v->threads > 1 ? "s" : "");
  write_overview(v, file.stream);
  write_not_yet(v, file.stream);
  for (int k = 0; k < v->case_count; k++)
    if (v->cases[k]->deed != CLI_NOT_YET) write_case(v, v->cases[k], plots, file.stream);
  return hb_file_end(&file, true, false, err);
}

/* One verdict with the numbers of all its meshes. */
static void json_verdict(const cli_validation *v, const cli_verdict *w, hb_json *json) {
  const cli_case *c = w->of;
  const cli_point *column = cli_case_points(v, c) + w->variant * c->mesh_count;
  int index = (int)(w->expect - c->expects);
  char label[200];
  cli_case_label(c, w->variant, label, sizeof label);
  hb_json_object(json, NULL);
  hb_json_text(json, "name", w->expect->name);
  hb_json_text(json, "at", label);
  hb_json_text(json, "kind", cli_kind_words[w->expect->kind]);
  hb_json_bool(json, "holds", w->good);
  hb_json_text(json, "why", w->good ? NULL : sentence(v, w));
  hb_json_number(json, "expected", w->expected);
  hb_json_number(json, "found", w->found);
  hb_json_number(json, "error", w->error);
  hb_json_number(json, "tolerance", w->tolerance);
  hb_json_bool(json, "relative", w->relative);
  hb_json_number(json, "order", w->order);
  hb_json_number(json, "expected_order", w->expect->order > 0 ? w->expect->order : (double)NAN);
  hb_json_number(json, "limit_error", w->limit_error);
  hb_json_array(json, "meshes");
  for (int m = 0; m < c->mesh_count; m++) {
    hb_json_object(json, NULL);
    hb_json_number(json, "size", column[m].size > 0 ? column[m].size : (double)NAN);
    hb_json_number(json, "found", column[m].err.status ? (double)NAN : column[m].found[index]);
    hb_json_number(json, "seconds", column[m].seconds);
    hb_json_object_end(json);
  }
  hb_json_array_end(json);
  hb_json_object_end(json);
}

/* report.json */
static hb_status write_json(const cli_validation *v, const char *path, hb_error *err) {
  hb_file file;
  hb_json json;
  hb_status status = hb_file_begin(path, &file, err);
  if (status) return status;
  counts n = count(v);
  hb_json_begin(&json, file.stream);
  hb_json_text(&json, "program", "hebra");
  hb_json_text(&json, "version", HB_VERSION);
  hb_json_integer(&json, "cases", n.cases);
  hb_json_integer(&json, "failed", n.failed);
  hb_json_integer(&json, "not_yet", n.not_yet);
  hb_json_integer(&json, "numbers", n.numbers);
  hb_json_integer(&json, "wrong", n.wrong);
  hb_json_number(&json, "wall_seconds", v->seconds);
  hb_json_integer(&json, "threads", v->threads);
  hb_json_array(&json, "results");
  for (int k = 0; k < v->case_count; k++) {
    const cli_case *c = v->cases[k];
    hb_json_object(&json, NULL);
    hb_json_text(&json, "name", c->name);
    hb_json_text(&json, "id", c->id);
    hb_json_text(&json, "title", c->title);
    hb_json_text(&json, "source", c->source);
    hb_json_text(&json, "check_file", c->path);
    hb_json_text(&json, "scene_file", c->scene);
    hb_json_text(&json, "deed", cli_deed_words[c->deed]);
    hb_json_text(&json, "not_yet", c->not_yet);
    if (c->deed != CLI_NOT_YET) hb_json_bool(&json, "holds", cli_case_holds(v, c));
    hb_json_array(&json, "numbers");
    for (int i = 0; i < v->verdict_count; i++)
      if (v->verdicts[i].of == c) json_verdict(v, &v->verdicts[i], &json);
    hb_json_array_end(&json);
    hb_json_object_end(&json);
  }
  hb_json_array_end(&json);
  hb_json_end(&json);
  return hb_file_end(&file, true, false, err);
}

/* Both. */
hb_status cli_validation_report(const cli_validation *v, const char *directory, bool plots, hb_error *err) {
  char *markdown = hb_file_join(directory, "report.md"), *json = hb_file_join(directory, "report.json");
  hb_status status =
      markdown && json ? hb_file_directory(directory, err) : hb_fail_memory(err, "names of reports");
  if (!status) status = write_markdown(v, markdown, plots, err);
  if (!status) status = write_json(v, json, err);
  hb_free(markdown);
  hb_free(json);
  return status;
}
