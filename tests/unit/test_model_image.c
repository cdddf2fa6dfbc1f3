/* test_model_image.c: the bytes of a saved model are those of its members: what lies between them
 * in memory does not reach them, and every member does. */
#include "unit.h"
#include "model/model.h"

#if defined(__has_builtin)
#if __has_builtin(__builtin_clear_padding)
#define KNOWS_PADDING 1
#endif
#endif

#if KNOWS_PADDING
/* Bytes of members, and between them; both are bytes of no count or size here. */
enum { VALUE = 0xA5, FILL = 0x5A, MANY = 3 };

/* A list of MANY elements, with VALUE in the bytes of members and FILL between them. */
#define LIST(list, number)                                                                         \
  do {                                                                                             \
    const size_t n = (void *)&m->list == (void *)&m->laws ? MANY * MANY : MANY;                    \
    m->number = MANY;                                                                              \
    m->list = malloc(n * sizeof *m->list);                                                         \
    memset(m->list, VALUE, n * sizeof *m->list);                                                   \
    for (size_t k = 0; k < n; k++) __builtin_clear_padding(&m->list[k]);                           \
    fill(m->list, n * sizeof *m->list);                                                            \
  } while (0)

static void fill(void *data, size_t size) {
  unsigned char *b = data;
  for (size_t k = 0; k < size; k++)
    if (b[k] != VALUE) b[k] = FILL;
}

static size_t count(const void *data, size_t size, unsigned char byte) {
  const unsigned char *b = data;
  size_t n = 0;
  for (size_t k = 0; k < size; k++) n += b[k] == byte;
  return n;
}

/* Sets pointers of the model, which are not written, and counts behind which there is nothing. */
static void clear_pointers(sd_model *m) {
  m->title = NULL, m->deck = NULL, m->mistakes = NULL, m->comm = NULL, m->mine = NULL,
  m->known = NULL;
  m->advised = NULL, m->segments = NULL, m->clump_disks = NULL, m->clump_offsets = NULL;
  m->parted = m->tiles.away = false;
}

static void clear_elements(sd_model *m) {
  for (int k = 0; k < MANY; k++) {
    m->materials[k].name = NULL;
    m->groups[k] = NULL;
    m->disks[k].name = NULL;
    m->walls[k].name = NULL, m->walls[k].points = NULL, m->walls[k].n_points = 0;
    m->clumps[k].name = NULL, m->clumps[k].disks = NULL;
    sd_motion *motion = &m->motions[k];
    motion->name = NULL, motion->bodies = NULL, motion->table_time = NULL,
    motion->table_value = NULL;
    motion->n_bodies = motion->n_table = 0;
    m->fields[k].name = NULL, m->fields[k].disks = NULL, m->fields[k].n_disks = 0;
    sd_phase *p = &m->phases[k];
    p->name = NULL, p->active = NULL, p->fields = NULL, p->hold = NULL, p->release = NULL;
    p->n_hold = p->n_release = 0;
    p->bond.between = NULL, p->bond.pairs = NULL;
    p->bond.n_between = p->bond.n_pairs = 0;
    m->averages[k].name = NULL, m->averages[k].text = NULL;
  }
}

typedef struct counted {
  size_t values, fills;
} counted;

static counted count_image(const sd_model *m) {
  size_t size;
  unsigned char *bytes = model_serialize(m, &size);
  assert_non_null(bytes);
  const counted c = {count(bytes, size, VALUE), count(bytes, size, FILL)};
  free(bytes);
  return c;
}

static void only_members_are_saved(void **unused) {
  sd_model *m = malloc(sizeof *m);
  memset(m, VALUE, sizeof *m);
  __builtin_clear_padding(m);
  fill(m, sizeof *m);
  clear_pointers(m);
  size_t values = 0, lists = 0;
#define EACH(list, number) LIST(list, number);
#define LISTS                                                                                      \
  EACH(materials, n_materials)                                                                     \
  EACH(laws, n_materials)                                                                          \
  EACH(groups, n_groups)                                                                           \
  EACH(disks, n_disks)                                                                             \
  EACH(walls, n_walls)                                                                             \
  EACH(clumps, n_clumps)                                                                           \
  EACH(motions, n_motions)                                                                         \
  EACH(fields, n_fields)                                                                           \
  EACH(phases, n_phases)                                                                           \
  EACH(rains, n_rains)                                                                             \
  EACH(memories, n_memories)                                                                       \
  EACH(derivatives, n_derivatives)                                                                 \
  EACH(tiles.walls, tiles.n_walls)                                                                 \
  EACH(rotations, n_rotations)                                                                     \
  EACH(slides, n_slides)                                                                           \
  EACH(contact_disks, n_contact_disks)                                                             \
  EACH(averages, n_averages)
  LISTS
  clear_elements(m);
#undef EACH
#define EACH(list, number)                                                                         \
  {                                                                                                \
    const size_t n = (void *)&m->list == (void *)&m->laws ? MANY * MANY : MANY;                    \
    values += count(m->list, n * sizeof *m->list, VALUE);                                          \
    lists++;                                                                                       \
  }
  LISTS
  sd_model shell = *m; /* addresses may have any bytes */
#undef EACH
#define EACH(list, number) shell.list = NULL;
  LISTS
  values += count(&shell, sizeof shell, VALUE);
  const counted found = count_image(m);

  /* sizes and counts may have such bytes, too: those of a model in which all else is 0 */
#undef EACH
#define EACH(list, number)                                                                         \
  memset(m->list, 0, ((void *)&m->list == (void *)&m->laws ? MANY * MANY : MANY) * sizeof *m->list);
  LISTS
  sd_model zero = {0};
#undef EACH
#define EACH(list, number) zero.list = m->list, zero.number = m->number;
  LISTS
  const counted base = count_image(&zero);
  print_message("  %zu lists, %zu bytes of members\n", lists, values);
  assert_int_equal(found.fills, base.fills);
  assert_int_equal(found.values - base.values, values);
#undef EACH
#define EACH(list, number) free(m->list);
  LISTS
  free(m);
}
#else
static void only_members_are_saved(void **unused) { skip(); }
#endif

RUN_TESTS(TEST(only_members_are_saved))
