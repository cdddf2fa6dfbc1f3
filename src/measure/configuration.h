/* configuration.h: one frame of a run, as measuring wants it: the disks in play, walls where they stand, and all
 * contacts with their geometry.
 *
 * The bodies are a finished sd_model of their own: `model` holds only what takes part in this frame, in poses
 * of this frame, with the edges of the periodic box and the region as they are now. Disks are numbered anew, `number`
 * says which they are in the deck; walls follow the disks, as in any model.
 *
 * Contacts come with the frame (a contact table), or are found from positions and velocities by the engine's
 * own neighbour search and law. Then skins are not stretched: tau is NAN and nothing slides.
 */
#ifndef MEASURE_CONFIGURATION_H
#define MEASURE_CONFIGURATION_H

#include <math.h>

#include "base/comm.h"
#include "measure/region.h"
#include "model/model.h"
#include "model/slot_table.h"

/* A stored frame: one row per body of the run, in the order of body numbers (disks, walls). */
typedef struct frame_data {
  int64_t step;
  double time;
  double scale; /* lengths of the region over those of the deck */
  double stretch[2],
      offset; /* of a box that deforms: lengths over these, shift of a row of cells */
  double gradient[SD_CELL_COMPONENTS]; /* its velocity gradient */
  size_t n_bodies, n_disks;
  const comm *comm; /* its ranks share them: ... (NULL: all are here) */
  size_t n_own;     /* ... so many of its own, ghosts, prescribed ones, which all have */
  double (*position)[2], (*velocity)[2]; /* in the periodic box */
  double *angle, *spin;
  int32_t *activity;   /* [n_disks] SD_IN_PLAY ... */
  int32_t (*image)[2]; /* [n_disks] absolute position = position + image * length of the box */
  bool has_contacts;   /* a table is there, maybe with no rows */
  size_t n_contacts;
  uint32_t *a, *b, *part; /* body numbers of the run */
  double *overlap, *force, *tau;
  double *roll; /* rolling force; 0 where it is not stored */
  int32_t *slide;
} frame_data;

sd_status frame_data_new(frame_data *f, size_t n_disks, size_t n_walls, sd_messages *messages);
sd_status frame_data_contacts(frame_data *f, size_t n,
                              sd_messages *messages); /* room for a table of n rows */
void frame_data_free(frame_data *f);
/* The state as a frame, with its contacts. frame_data_free also when it fails. */
sd_status frame_data_of_state(frame_data *f, const sd_model *model, const sd_state *state,
                              sd_messages *messages);
/* The same of one rank's part, whose bodies have their slots as numbers. constants: a model of
 * these bodies, of which only `disks` is to be freed, also when it fails. */
sd_status frame_data_of_part(frame_data *f, sd_model *constants, const sd_model *model,
                             const sd_state *part, const slot_table *slots, const comm *c,
                             sd_messages *messages);

typedef struct config_contact {
  uint32_t a, b, part; /* a: a free disk; numbers of configuration.model */
  double nx, ny;       /* unit vector from a to b's surface */
  double lx,
      ly; /* branch vector of the disks: to b's centre, or to the surface of a wall or prescribed disk */
  double x, y;   /* the point of contact */
  double fx, fy; /* force on b, without the tangential one where tau is NAN */
  double overlap, force, tau, mu;
  double roll, couple; /* rolling force, and its torque on a, of opposite sign on b */
  double k_t;          /* tau = -k_t zeta; 0: it is not */
  double push;         /* normal force without attraction, to which friction is limited */
  int slide;
} config_contact;

/* A rigid body of several disks. */
typedef struct config_clump {
  size_t n_disks;  /* in play; 0: it is not there */
  uint32_t *disks; /* ascending */
  double mass, inertia;
  double position[2],
      velocity[3]; /* of its centre of mass, which may lie beyond the edge of the box */
  double force[2]; /* constant, its disks' included */
} config_clump;

typedef struct configuration {
  int64_t step;
  double time;
  sd_model *model;
  uint32_t *number; /* [model->n_disks] in the deck */
  size_t n_deck;    /* disks of the deck */
  size_t n_waiting, n_removed;
  double length[2];                    /* of the periodic box, 0 where it is open */
  double offset;                       /* of a row of its cells against the one below */
  double gradient[SD_CELL_COMPONENTS]; /* of velocities in a box that deforms */
  const comm *comm;                    /* as in the frame; functions that say so are collective */
  size_t n_own;
  bool recomputed;   /* contacts were not stored */
  bool frictionless; /* no pair of materials has k_t > 0 and mu > 0 */
  size_t n_contacts;
  config_contact *contacts;
  size_t n_clumps; /* 0: there are none, and nothing of the following */
  config_clump *clumps;
  int32_t *clump_of;     /* [model->n_disks] -1: in none */
  uint32_t *clump_disks; /* those of each clump */
  double (*arm)[2];      /* [model->n_disks] from the centre of its clump, 0 of other disks */
} configuration;

/* constants: a model of the run (disks, walls, laws, box, region); only what a frame does not have is read. While no disk is
 * in play there are walls, box and region only. configuration_free also when it fails. SD_ERROR_USER: the frame does not
 * fit the model. Collective. */
sd_status configuration_new(configuration *c, const sd_model *constants, const frame_data *frame,
                            sd_messages *messages);
void configuration_free(configuration *c);

/* Rigid bodies of the disks in play; from: as constants above. SD_ERROR_IO: no memory. A part of configuration_new. */
sd_status configuration_clumps(configuration *c, const sd_model *from, const frame_data *frame);
void configuration_clumps_free(configuration *c);
/* Branch vector between rigid bodies: from the centre of a, or of its clump, to that of b, or to the surface of a wall or prescribed
 * disk. */
void configuration_branch(const configuration *c, const config_contact *k, double from[2],
                          double l[2]);
/* Does the disk move by itself? */
static inline bool configuration_in_clump(const configuration *c, size_t disk) {
  return c->n_clumps > 0 && c->clump_of[disk] >= 0;
}

/* Region whose filling is measured: that of the model, with walls that have moved, the periodic box along periodic directions, and where neither
 * says anything the rectangle about all disks. wanted (may be NULL): x0, x1, y0, y1 instead. Collective. */
region configuration_region(const configuration *c, const double *wanted);
/* Edges of that region which are neither a wall nor periodic: what is per area depends on where they are put. Bit 2 c + 0
 * or 1: lower or upper edge of coordinate c. */
unsigned configuration_open(const configuration *c);
/* Index of a body's material. */
static inline int configuration_material(const sd_model *m, uint32_t body) {
  return body < m->n_disks ? m->disks[body].material : m->walls[body - m->n_disks].material;
}
/* tau of stored contact c: -k_t zeta where laws need no more, without -0. a, b: its materials. */
static inline double configuration_tau_of(const sd_model *m, const sd_state *s, size_t c, int a,
                                          int b) {
  return 0.0 + (s->law_columns ? s->contact_tau[c]
                               : 0.0 - sd_model_law(m, a, b)->k_t * s->contact_zeta[c]);
}
/* The model of a rank does not know the materials of all disks. */
static inline double configuration_tau(const sd_model *m, const sd_state *s,
                                       const slot_table *slots, size_t c) {
  return configuration_tau_of(m, s, c, s->material[slot_of(slots, s->contact_a[c])],
                              s->material[slot_of(slots, s->contact_b[c])]);
}
/* Is the disk one that this rank adds to sums? */
static inline bool configuration_counts(const configuration *c, uint32_t disk) {
  return !c->comm || c->number[disk] < c->n_own ||
         (c->model->disks[disk].driven && comm_rank(c->comm) == 0);
}
/* b of a contact can be a disk that moves. */
static inline bool configuration_is_free(const configuration *c, uint32_t body) {
  return body < c->model->n_disks && !c->model->disks[body].driven;
}
/* Point k of a wall of the run as it stands in a frame: turned about its pivot, and gone where that went. */
void configuration_wall_point(const sd_wall *wall, const frame_data *frame, size_t body, size_t k,
                              double at[2]);
/* Is a disk of this activity there: neither waiting nor removed? */
static inline bool configuration_in_play(int32_t activity) {
  return activity == SD_IN_PLAY || activity == SD_OUTSIDE;
}
/* Makes the vector between two points the shortest one. */
static inline void configuration_nearest(const configuration *c, double d[2]) {
  for (int k = 1; k >= 0; k--) {
    if (!(c->length[k] > 0.0)) continue;
    const double n = nearbyint(d[k] / c->length[k]);
    d[k] -= c->length[k] * n;
    if (k == 1) d[0] -= c->offset * n;
  }
}
static inline double configuration_radius(const configuration *c) { /* mean */
  double sum = 0.0;
  for (size_t i = 0; i < c->model->n_disks; i++) sum += c->model->disks[i].radius;
  return c->model->n_disks ? sum / (double)c->model->n_disks : 0.0;
}

#endif
