/* deck_materials.c: materials, the laws between them, and walls. See deck.h. */
#include <stdlib.h>
#include <string.h>

#include "base/limits.h"
#include "io/deck/deck_read.h"

static sd_contact_law read_law(deck_group *g) {
  sd_contact_law law = {.k_n = deck_number(g, "k_n"), .k_t = deck_number(g, "k_t")};
  law.gamma_n = deck_number(g, "gamma_n");
  law.mu = deck_number(g, "mu");
  return law;
}

int deck_material(deck *d, const deck_node *node, const char *name) {
  const sd_model *m = d->model;
  uint32_t found;
  if (deck_index_find(&d->materials, name, &found)) return (int)found;
  if (!node) return -1;
  deck_guess guess = deck_guess_start(name);
  for (size_t k = 0; k < m->n_materials && !deck_told(d); k++) deck_guess_add(&guess, m->materials[k].name);
  deck_fail(d, node, "no material is called that%s%s%s", guess.best ? "; did you mean \"" : "",
            guess.best ? guess.best : "", guess.best ? "\"?" : "");
  return -1;
}

static void read_pair(deck *d, deck_node *node) {
  sd_model *m = d->model;
  deck_group g;
  if (!deck_enter(d, node, &deck_pairs, &g)) return;
  sd_contact_law law = read_law(&g);
  deck_node *names = deck_get(&g, "materials");
  if (!names || names->type != DECK_LIST || names->n != 2) {
    deck_fail_key(d, node, "materials", "expected the names of two materials (\"a\", \"b\")");
    return;
  }
  int pair[2];
  for (int k = 0; k < 2; k++) {
    const deck_node *name = names->child[k];
    bool text = name->type == DECK_STRING;
    pair[k] = text ? deck_material(d, name, name->value.text) : -1;
    if (!text) deck_fail(d, name, "expected the name of a material");
  }
  if (pair[0] < 0 || pair[1] < 0) return;
  sd_contact_law *one = &m->laws[(size_t)pair[0] * m->n_materials + (size_t)pair[1]];
  if (pair[0] == pair[1])
    deck_fail(d, names, "the law of a material with itself stands in materials");
  else if (one->k_n != 0)
    deck_fail(d, names, "this pair is given twice");
  *one = m->laws[(size_t)pair[1] * m->n_materials + (size_t)pair[0]] = law;
}

void deck_read_materials(deck *d) {
  sd_model *m = d->model;
  deck_node *list = deck_groups(d, d->root, "materials");
  size_t n = list ? list->n : 0;
  if (n > LIMIT_MATERIALS) {
    deck_fail(d, list, "%zu materials; expected at most %d", n, LIMIT_MATERIALS);
    n = LIMIT_MATERIALS;
  }
  m->materials = deck_keep(d, n, sizeof *m->materials);
  m->laws = deck_keep(d, n * n, sizeof *m->laws);
  m->n_materials = n;
  for (size_t k = 0; k < n; k++) m->materials[k].name = deck_keep_text(d, "");
  for (size_t k = 0; k < n; k++) {
    deck_group g;
    if (!deck_enter(d, list->child[k], &deck_materials, &g)) continue;
    const char *name = deck_text_of(&g, "name");
    if (name && deck_material(d, NULL, name) >= 0)
      deck_fail_key(d, g.node, "name", "two materials have this name");
    if (name && !*name) deck_fail_key(d, g.node, "name", "expected a name that is not empty");
    m->laws[k * n + k] = read_law(&g);
    if (!name) continue;
    char *old = m->materials[k].name;
    m->materials[k].name = deck_keep_text(d, name);
    deck_index_add(d, &d->materials, m->materials[k].name, (uint32_t)k);
    free(old);
  }
  if (!list && !deck_child(d->root, "materials"))
    deck_fail_key(d, d->root, "materials", "missing: expected ( { name = \"...\"; k_n = ...; ... } )");
  else if (list && n == 0)
    deck_fail(d, list, "expected at least one material");
  deck_node *pairs = deck_groups(d, d->root, "material_pairs");
  for (size_t k = 0; pairs && k < pairs->n; k++) read_pair(d, pairs->child[k]);
}

/* Two different materials that can touch need a law: at least one has a disk that is free to move. */
void deck_check_laws(deck *d) {
  const sd_model *m = d->model;
  size_t n = m->n_materials;
  bool *is_free = deck_alloc(d, n + 1, sizeof(bool)), *used = deck_alloc(d, n + 1, sizeof(bool));
  for (size_t i = 0; i < m->n_disks; i++) {
    if (m->disks[i].material < 0) continue;
    used[m->disks[i].material] = true;
    if (!deck_is_driven(d, i)) is_free[m->disks[i].material] = true;
  }
  for (size_t w = 0; w < m->n_walls; w++)
    if (m->walls[w].material >= 0) used[m->walls[w].material] = true;
  for (size_t a = 0; a < n; a++)
    for (size_t b = a + 1; b < n; b++) {
      bool touch = (is_free[a] && used[b]) || (is_free[b] && used[a]);
      if (touch && m->laws[a * n + b].k_n == 0)
        deck_fail_key(
            d, d->root, "material_pairs",
            "materials \"%s\" and \"%s\" can touch; expected { materials = (\"%s\", \"%s\"); k_n = ...; }",
            m->materials[a].name, m->materials[b].name, m->materials[a].name, m->materials[b].name);
    }
}

/* --- walls ---------------------------------------------------------------------------------------------- */

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
  wall->points = deck_keep(d, list->n, sizeof *wall->points);
  wall->n_points = list->n;
  for (size_t k = 0; k < list->n; k++) {
    deck_node *point = list->child[k];
    if (point->type != DECK_LIST || point->n != 2) {
      deck_fail(d, point, "expected a point (x, y)");
      continue;
    }
    for (size_t c = 0; c < 2; c++) deck_value_number(d, point->child[c], false, &wall->points[k][c]);
    const double *now = wall->points[k], *before = wall->points[k ? k - 1 : 0];
    if (k > 0 && now[0] == before[0] && now[1] == before[1])
      deck_fail(d, point, "the same as the point before");
  }
  const double *first = wall->points[0], *last = wall->points[list->n - 1];
  if (wall->closed && list->n < 3) deck_fail(d, list, "a closed polyline needs three points or more");
  if (wall->closed && first[0] == last[0] && first[1] == last[1])
    deck_fail(d, list->child[list->n - 1], "the same as the first point, to which `closed` joins it already");
}

static void read_straight(deck_group *g, sd_wall *wall) {
  if (wall->kind == SD_WALL_POLYLINE) wall->closed = deck_bool(g, "closed");
  read_points(g, wall);
  double mean[2] = {0, 0};
  for (size_t k = 0; k < wall->n_points; k++)
    for (int c = 0; c < 2; c++) mean[c] += wall->points[k][c] / (double)wall->n_points;
  if (wall->n_points) deck_default_pair(g, "pivot", mean);
  deck_pair(g, "pivot", wall->pivot);
}

static void read_wall(deck *d, deck_node *node, sd_wall *wall) {
  deck_group g;
  *wall = (sd_wall){.material = -1};
  if (!deck_enter(d, node, &deck_walls, &g)) return;
  const char *name = deck_text_of(&g, "name");
  wall->name = deck_keep_text(d, name);
  if (d->model->n_materials == 1) deck_default_text(&g, "material", d->model->materials[0].name);
  const char *material = deck_text_of(&g, "material");
  if (material) wall->material = deck_material(d, deck_get(&g, "material"), material);
  if (!deck_get(&g, "material"))
    deck_fail_key(d, node, "material", "missing: expected the name of a material");
  int kind = deck_choice(&g, "type");
  if (kind < 0) return;
  deck_check_shape(&g, &deck_wall_kinds[kind], deck_wall_kinds, deck_wall_kind_count);
  wall->kind = (sd_wall_kind)deck_wall_kinds[kind].kind;
  if (wall->kind != SD_WALL_CIRCLE) {
    read_straight(&g, wall);
    return;
  }
  deck_pair(&g, "center", wall->pivot);
  wall->radius = deck_number(&g, "radius");
  wall->inside = deck_choice(&g, "side") == 0;
}

void deck_read_walls(deck *d) {
  sd_model *m = d->model;
  deck_node *list = deck_groups(d, d->root, "walls");
  m->walls = deck_keep(d, list ? list->n : 0, sizeof *m->walls);
  for (size_t k = 0; list && k < list->n; k++) {
    sd_wall *wall = &m->walls[k];
    m->n_walls = k + 1;
    read_wall(d, list->child[k], wall);
    uint32_t disk;
    if (wall->name && !deck_index_add(d, &d->walls, wall->name, (uint32_t)k))
      deck_fail_key(d, list->child[k], "name", "two walls have this name");
    if (wall->name && deck_disk_called(d, wall->name, &disk))
      deck_fail_key(d, list->child[k], "name", "a disk has this name too");
  }
}
