/* deck_fields.c: reads the list `fields` (body forces). See deck_tree.h. */
#include <string.h>

#include "base/memory.h"
#include "io/deck/deck_read.h"
#include "model/field_kinds.h"

static void read_field(deck *d, deck_node *node, sd_body_force *field) {
  deck_group g;
  if (!deck_enter(d, node, &deck_fields, &g)) return;
  if (deck_given(&g, "alpha") && !deck_given(&g, "alpha_rotation"))
    deck_default_number(&g, "alpha_rotation", deck_number(&g, "alpha"));
  if (!deck_fill(&g, field)) return;
  if (field->alpha >= 1 || field->alpha_rotation >= 1)
    deck_fail_key(
        &g, field->alpha >= 1 ? "alpha" : "alpha_rotation",
        "it would hold every disk where it is; expected a number below 1, usually 0.1 to 0.8");
  if (field->power < -FIELD_MOST_POWER || field->power > FIELD_MOST_POWER)
    deck_fail_key(&g, "power", "expected a whole number from %d to %d", -FIELD_MOST_POWER,
                  FIELD_MOST_POWER);
  if (!deck_given(&g, "disk") && !deck_given(&g, "group")) return;
  const size_t before = d->reported;
  const deck_bodies on = deck_select(&g, false);
  if (on.n == 0 && d->reported == before)
    deck_fail(d, node, "it acts on no disk: the group is empty");
  field->n_disks = on.n;
  field->disks = deck_keep(d, on.n, sizeof *field->disks);
  if (on.n) memcpy(field->disks, on.body, on.n * sizeof *field->disks);
}

void deck_read_fields(deck *d) {
  sd_model *m = d->model;
  deck_node *list = deck_groups(d, d->root, "fields");
  m->fields = memory_new(list ? list->n : 0, sizeof *m->fields);
  for (size_t k = 0; list && k < list->n; k++) {
    m->n_fields = k + 1;
    read_field(d, list->child[k], &m->fields[k]);
    if (m->fields[k].name && !deck_index_add(d, &d->fields, m->fields[k].name, (uint32_t)k))
      deck_fail_child(d, list->child[k], "name", "two fields have this name");
  }
}
