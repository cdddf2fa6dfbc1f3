/* deck_materials.c: reads materials, the contact laws between them, and walls. See deck_tree.h. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/limits.h"
#include "base/math.h"
#include "base/memory.h"
#include "io/deck/deck_read.h"
#include "model/laws.h"
#include "model/normal_laws.h"
#include "model/walls.h"

/* --- materials -------------------------------------------------------------------------------- */

int deck_material(deck_group *g) {
  deck *d = g->d;
  uint32_t number;
  if (d->model->n_materials == 1) deck_default_text(g, "material", d->model->materials[0].name);
  const deck_node *node = deck_get(g, "material");
  if (!node && d->model->n_materials > 1)
    deck_fail_key(g, "material", "missing: expected the name of a material");
  if (!node || !deck_text_of(g, "material")) return -1;
  return deck_index_look_up(d, &d->materials, "material", node, "", &number) ? (int)number : -1;
}

/* Warns of a rolling stiffness k_r without rolling friction mu_r, which has no effect. An
 * explicit mu_r = 0 is accepted, as sweeps set it. */
static void warn_of_rolling(const deck_group *g, const sd_contact_law *law) {
  if (!(law->k_r > 0) || law->mu_r > 0 || deck_given(g, "mu_r")) return;
  const deck_node *k_r = deck_get(g, "k_r");
  sd_warn(g->d->messages,
          "%s: %s = %g without mu_r has no effect: the couple is at most mu_r R_eff F_n; give "
          "mu_r, or leave "
          "k_r out",
          deck_place_text(g->d, k_r->place), deck_node_path(g->d, k_r), law->k_r);
}

/* Completes the law that was read, and reports mistakes in it. */
static void check_law(const deck_group *g, sd_contact_law *law) {
  const char *key = NULL;
  double value;
  if (!deck_given(g, "k_n") && !deck_given(g, "E_star")) {
    deck_fail_key(g, "k_n",
                  "missing: expected a number > 0 (normal stiffness), or E_star with law = "
                  "\"hertz\"");
    law->k_n = NAN;
  }
  law_complete(law);
  char *text = law_mistake(law, &key, &value);
  /* A missing key was reported before, when the kind of law was read */
  if (text && deck_get(g, key)) deck_fail_key(g, key, "%s", text);
  free(text);
  warn_of_rolling(g, law);
}

static void read_pair(deck_group *g) {
  deck *d = g->d;
  sd_model *m = d->model;
  sd_contact_law law = {0};
  deck_fill(g, &law);
  check_law(g, &law);
  deck_node *names = deck_get(g, "materials");
  if (!names || names->type != DECK_LIST || names->n != 2) {
    deck_fail_key(g, "materials", "expected the names of two materials (\"a\", \"b\")");
    return;
  }
  uint32_t pair[2];
  bool found = true;
  for (int k = 0; k < 2; k++) {
    const deck_node *name = names->child[k];
    if (name->type != DECK_STRING) deck_fail(d, name, "expected the name of a material");
    found = name->type == DECK_STRING &&
            deck_index_look_up(d, &d->materials, "material", name, "", &pair[k]) && found;
  }
  if (!found) return;
  sd_contact_law *one = &m->laws[pair[0] * m->n_materials + pair[1]];
  if (pair[0] == pair[1])
    deck_fail(d, names, "the law of a material with itself stands in materials");
  else if (law_is_given(one))
    deck_fail(d, names, "this pair is given twice");
  *one = m->laws[pair[1] * m->n_materials + pair[0]] = law;
}

static void read_material(deck *d, deck_node *node, size_t k) {
  sd_model *m = d->model;
  deck_group g;
  m->materials[k].name = memory_text("");
  if (!deck_enter(d, node, &deck_materials, &g)) return;
  const char *name = deck_text_of(&g, "name");
  if (name && !deck_index_add(d, &d->materials, name, (uint32_t)k))
    deck_fail_key(&g, "name", "two materials have this name");
  if (name && !*name) deck_fail_key(&g, "name", "expected a name that is not empty");
  deck_fill(&g, &m->laws[k * m->n_materials + k]);
  check_law(&g, &m->laws[k * m->n_materials + k]);
  if (!name) return;
  free(m->materials[k].name);
  m->materials[k].name = memory_text(name);
}

void deck_read_materials(deck *d) {
  sd_model *m = d->model;
  deck_node *list = deck_groups(d, d->root, "materials");
  size_t n = list ? list->n : 0;
  if (n > LIMIT_MATERIALS) {
    deck_fail(d, list, "%zu materials; expected at most %d", n, LIMIT_MATERIALS);
    n = LIMIT_MATERIALS;
  }
  m->materials = memory_new(n, sizeof *m->materials);
  m->laws = memory_new(n * n, sizeof *m->laws);
  m->n_materials = n;
  for (size_t k = 0; k < n; k++) read_material(d, list->child[k], k);
  for (size_t k = n; list && k < list->n; k++) { /* beyond the limit: their names do exist */
    const deck_node *name = deck_child(list->child[k], "name");
    if (name && name->type == DECK_STRING) deck_index_add(d, &d->materials, name->value.text, 0);
  }
  if (!list && !deck_child(d->root, "materials"))
    deck_fail_child(d, d->root, "materials",
                    "missing: expected ( { name = \"...\"; k_n = ...; ... } )");
  else if (list && n == 0)
    deck_fail(d, list, "expected at least one material");
  deck_group pair;
  for (size_t k = 0; deck_next(d, &deck_pairs, &k, &pair);) read_pair(&pair);
}

void deck_check_laws(deck *d) {
  const sd_model *m = d->model;
  law_use *use = deck_alloc(d, m->n_materials, sizeof *use);
  laws_count_uses(m, use);
  for (size_t a = 0, b = 1; laws_find_missing(m, use, &a, &b); b++) {
    const char *one = m->materials[a].name, *two = m->materials[b].name;
    if (a != b)
      deck_fail_child(d, d->root, "material_pairs",
                      "materials \"%s\" and \"%s\" can touch; expected { materials = (\"%s\", "
                      "\"%s\"); k_n = ...; }",
                      one, two, one, two);
  }
}

/* --- walls ------------------------------------------------------------------------------------ */

static void read_points(deck_group *g, sd_wall *wall) {
  deck *d = g->d;
  deck_node *list = deck_get(g, "points");
  if (!list) return;
  size_t least = 2, most = wall->kind == SD_WALL_POLYLINE ? SIZE_MAX : 2;
  if (list->type != DECK_LIST || list->n < least || list->n > most) {
    deck_fail(d, list, "expected %s points ((x, y), (x, y)%s)", most == 2 ? "two" : "two or more",
              most == 2 ? "" : ", ...");
    return;
  }
  wall->points = memory_new(list->n, sizeof *wall->points);
  wall->n_points = list->n;
  for (size_t k = 0; k < list->n; k++) {
    deck_node *point = list->child[k];
    if (point->type != DECK_LIST || point->n != 2) {
      deck_fail(d, point, "expected a point (x, y)");
      continue;
    }
    for (size_t c = 0; c < 2; c++)
      deck_value_number(d, point->child[c], false, &wall->points[k][c]);
    const double *now = wall->points[k], *before = wall->points[k ? k - 1 : 0];
    if (k > 0 && now[0] == before[0] && now[1] == before[1])
      deck_fail(d, point, "the same as the point before");
  }
  const double *first = wall->points[0], *last = wall->points[list->n - 1];
  if (wall->closed && list->n < 3)
    deck_fail(d, list, "a closed polyline needs three points or more");
  if (wall->closed && first[0] == last[0] && first[1] == last[1])
    deck_fail(d, list->child[list->n - 1],
              "the same as the first point, to which `closed` joins it already");
}

/* Reports an arc with a wrong opening angle. If its angles are bare numbers beyond a whole turn,
 * the message says that degrees may have been meant. */
static void fail_arc(const deck_group *g, const sd_wall *wall) {
  static const char *const expected = "expected counterclockwise, by a whole turn at most";
  const bool bare =
      deck_get(g, "from")->type == DECK_FLOAT && deck_get(g, "to")->type == DECK_FLOAT;
  if (bare && math_max(fabs(wall->from), fabs(wall->to)) > 2.0 * M_PI)
    deck_fail_key(
        g, "to",
        "the arc runs from %g to %g rad; %s; angles are in radians, degrees are \"%.10g deg\"",
        wall->from, wall->to, expected, wall->to);
  else
    deck_fail_key(g, "to", "the arc runs from %.4g to %.4g degrees; %s", wall->from * 180.0 / M_PI,
                  wall->to * 180.0 / M_PI, expected);
}

static void read_arc(deck_group *g, sd_wall *wall) {
  const double opening = wall->to - wall->from;
  if (deck_given(g, "from") && deck_given(g, "to") && !(opening > 0.0 && opening <= ARC_RING))
    fail_arc(g, wall);
  wall->points = memory_new(ARC_POINTS, sizeof *wall->points);
  arc_trace(wall);
  if (deck_given(g, "pivot")) return;
  memcpy(wall->pivot, wall->center, sizeof wall->pivot);
  deck_default_pair(g, "pivot", wall->pivot);
}

static void read_wall(deck *d, deck_node *node, sd_wall *wall) {
  deck_group g;
  if (!deck_enter(d, node, &deck_walls, &g)) return;
  wall->material = deck_material(&g);
  if (!deck_fill(&g, wall)) return;
  if (wall->kind == SD_WALL_CIRCLE) memcpy(wall->pivot, wall->center, sizeof wall->pivot);
  if (wall->kind == SD_WALL_CIRCLE) return;
  if (wall->kind == SD_WALL_ARC) {
    read_arc(&g, wall);
    return;
  }
  read_points(&g, wall);
  if (wall->n_points && !deck_given(&g, "pivot")) {
    wall_set_pivot(wall);
    deck_default_pair(&g, "pivot", wall->pivot);
  }
}

void deck_read_walls(deck *d) {
  sd_model *m = d->model;
  deck_node *list = deck_groups(d, d->root, "walls");
  m->walls = memory_new(list ? list->n : 0, sizeof *m->walls);
  for (size_t k = 0; list && k < list->n; k++) {
    sd_wall *wall = &m->walls[k];
    m->n_walls = k + 1;
    wall->material = -1;
    read_wall(d, list->child[k], wall);
    uint32_t disk;
    if (wall->name && !deck_index_add(d, &d->walls, wall->name, (uint32_t)k))
      deck_fail_child(d, list->child[k], "name", "two walls have this name");
    if (wall->name && deck_index_find(&d->disks, wall->name, &disk))
      deck_fail_child(d, list->child[k], "name", "a disk has this name too");
  }
}
