/* configuration.h: one frame of a run, prepared for measurements: the disks in play, the walls at
 * their current poses, and all contacts with their geometry.
 *
 * The bodies form a complete sd_model of their own: `model` holds only the bodies of this frame, at
 * their poses of this frame, with the current edges of periodic box and region. Disks are
 * renumbered; `number` maps them to the deck's numbers. Walls have the numbers after those of the
 * disks, as in any model.
 *
 * Contacts come from the frame's contact table. If it has none, the engine's neighbour search and
 * force law find them from positions and velocities; the tangential displacement is then unknown,
 * so tau is NAN and no contact slides. */
#ifndef MEASURE_CONFIGURATION_H
#define MEASURE_CONFIGURATION_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#include "model/containers.h"
#include "model/state.h"
#include "slipdisk/model.h"

/* --- regions ---------------------------------------------------------------------------------- */

/* The part of the plane over which a configuration is measured, and areas within it.
 *
 * A region is a rectangle, or the inside of a container that is none. Areas of disks in it are
 * exact: straight edges divide a circle into triangles and sectors, a round edge cuts a lens out of
 * it. */

typedef struct region {
  double lower[2], upper[2];
  /* [c] true if the region spans the whole period along c, so that it has no edges there */
  bool whole[2];
  /* [c] period along coordinate c if this direction is periodic and the region does not span it, so
   * that the region has periodic images; else 0 */
  double image[2];
  /* outline inside the rectangle from lower to upper; empty: the region is the rectangle */
  container_outline outline;
} region;

static inline bool region_is_round(const region *g) {
  return g->outline.n == 0 && g->outline.radius > 0.0;
}
/* Cuts the region to the inside of an outline: if walls close it all around, the rectangle becomes
 * its bounding box; else the outline ends at the lower and upper edge of the rectangle. Does
 * nothing for an empty outline. */
void region_use_outline(region *g, const container_outline *o, bool closed);
double region_area(const region *g);
/* Returns true if the point, or a periodic image of it, lies in the region or on its edge. */
bool region_holds(const region *g, double x, double y);
/* Returns the area that a disk and its periodic images cover inside the region. */
double region_disk(const region *g, double x, double y, double radius);
/* Returns the fraction, 0 to 1, of the line from (x, y) to (x + dx, y + dy) inside the region. For
 * a round region: 1 if the middle of the line lies in the region, else 0. */
double region_line(const region *g, double x, double y, double dx, double dy);

/* Returns the area that a circle of this radius about the origin shares with a polygon of n corners
 * in counter-clockwise order; negative for clockwise order. */
double region_circle_polygon(double radius, size_t n, const double (*corner)[2]);

/* --- frames and configurations ---------------------------------------------------------------- */

/* Extent of the disks in play: the largest values of -x, -y, x and y, in this order, of the centres
 * of free disks, and of the edges of all disks; -HUGE_VAL: there are none. */
typedef struct disk_extent {
  double centre[4], edge[4];
} disk_extent;
/* Extends *e so that it includes a disk with centre at[]. */
void disk_extent_add(disk_extent *e, const double at[2], double radius, bool free);

/* Stored frame: arrays with one row per body of the run, disks first, then walls. */
typedef struct frame_data {
  int64_t step;
  double time;
  /* compression: current lengths of the region divided by those of the deck (input file) */
  double scale;
  /* deforming box: stretch: factors of its lengths along x and y, on top of `scale`; offset: x
   * shift of the periodic image above */
  double stretch[2], offset;
  double gradient[SD_CELL_COMPONENTS]; /* velocity gradient of the box, 1/time: xx, yy, xy */
  size_t n_bodies, n_disks;
  disk_extent extent; /* extent of disks in play that have no rows in the frame */
  /* [n_bodies] x and y of the position, wrapped into the periodic box, and of the velocity */
  double (*position)[2], (*velocity)[2];
  double *angle, *spin;
  int32_t *activity; /* [n_disks] SD_IN_PLAY, SD_WAITING, ... (state.h) */
  /* [n_disks] periodic images: unwrapped position = position + image * box length */
  int32_t (*image)[2];
  bool has_contacts; /* true if a contact table is present, even with no rows */
  size_t n_contacts;
  /* a, b: numbers of the two bodies in the run; part: index of the wall segment, if b is a wall */
  uint32_t *a, *b, *part;
  double *overlap, *force, *tau;
  double *roll; /* rolling force; 0 if not stored */
  int32_t *slide;
  double *bond, *bond_pull, *bond_shear; /* 0 if there are no bonds */
} frame_data;

sd_status frame_data_new(frame_data *f, size_t n_disks, size_t n_walls, sd_messages *messages);
/* Allocates a contact table of n rows. SD_ERROR_IO: out of memory. */
sd_status frame_data_contacts(frame_data *f, size_t n, sd_messages *messages);
void frame_data_free(frame_data *f);
/* Copies the state and its contacts into a frame. Call frame_data_free also when it fails.
 * SD_ERROR_IO: out of memory. */
sd_status frame_data_of_state(frame_data *f, const sd_model *model, const sd_state *state,
                              sd_messages *messages);
/* Copies walls and deformation of the box from the state into a frame without disks; `model` is the
 * model of the run. Errors are those of frame_data_of_state. */
sd_status frame_data_of_walls(frame_data *f, const sd_model *model, const sd_state *state,
                              sd_messages *messages);

typedef struct config_contact {
  /* a, b: numbers of the two bodies in configuration.model, a is always a free disk; part: index of
   * the wall segment */
  uint32_t a, b, part;
  double nx, ny; /* unit normal from the centre of a towards b */
  /* branch vector: from the centre of a to the centre of b, or to the surface of b if it is a wall
   * or a prescribed disk */
  double lx, ly;
  double x, y;   /* point of contact */
  double fx, fy; /* force on b; without its tangential part if tau is NAN */
  double overlap, force, tau, mu;
  double bond, bond_pull, bond_shear; /* strength of a bond, 0: none; its tension and shear force */
  double roll, couple; /* roll: rolling force; couple: its torque on a (opposite sign on b) */
  /* tangential stiffness if tau = -k_t zeta with zeta the tangential displacement, else 0 */
  double k_t;
  /* normal force without attraction and bond, less the critical load, at least 0; friction is
   * limited to mu times this force */
  double push;
  int slide;
} config_contact;

/* Rigid body made of several disks, or one disk in no clump. */
typedef struct config_clump {
  size_t n_disks;  /* number of disks of the clump that are in play; 0: the clump is absent */
  uint32_t *disks; /* [n_disks] numbers of these disks, ascending */
  double mass, inertia;
  /* centre of mass: position (x, y), which may lie outside the box, and velocity (x, y, angular) */
  double position[2], velocity[3];
  double force[2]; /* constant body force (x, y), with the forces on its disks */
} config_clump;

typedef struct configuration {
  int64_t step;
  double time;
  sd_model *model;
  uint32_t *number; /* [model->n_disks] number that each disk has in the deck (input file) */
  size_t n_deck;    /* number of disks of the deck, those not in play included */
  size_t n_waiting, n_removed;
  double length[2];          /* lengths of the periodic box along x and y, 0: not periodic */
  container_outline outline; /* of the container as its walls are now; empty: a rectangle */
  double offset;             /* x shift of the periodic image above, in a sheared box */
  double gradient[SD_CELL_COMPONENTS]; /* velocity gradient of a box that deforms: xx, yy, xy */
  disk_extent extent;                  /* that of the frame, and of the disks in model */
  /* true if the contacts were not stored but computed from positions and velocities */
  bool recomputed;
  bool frictionless; /* true if no pair of materials has k_t > 0 and mu > 0 */
  size_t n_contacts;
  config_contact *contacts;
  size_t n_clumps; /* number of clumps; 0: the members below are unset */
  config_clump *clumps;
  int32_t *clump_of;     /* [model->n_disks] index of the clump of each disk, -1: none */
  uint32_t *clump_disks; /* numbers of the disks of all clumps, clump by clump */
  /* [model->n_disks] vector from the centre of mass of its clump to each disk, 0: in no clump */
  double (*arm)[2];
} configuration;

/* Builds the configuration of a frame. constants: model of the run (disks, walls, laws, box,
 * region), from which everything is read that the frame lacks. Without a disk in play only walls,
 * box and region are set. Call configuration_free also when it fails. SD_ERROR_USER: the frame does
 * not fit the model. */
sd_status configuration_new(configuration *c, const sd_model *constants, const frame_data *frame,
                            sd_messages *messages);
void configuration_free(configuration *c);

/* Finds the clumps among the disks in play. from: model of the run, the argument `constants` of
 * configuration_new, which calls this function. SD_ERROR_IO: out of memory. */
sd_status configuration_clumps(configuration *c, const sd_model *from, const frame_data *frame);
void configuration_clumps_free(configuration *c);
/* Computes mass, moment of inertia, centre of mass, velocity and force of a clump from the rows
 * disks[i] of its disks, i in k->disks. arm[i]: vector to each disk, from the first disk before the
 * call, from the centre of mass after it. */
void configuration_clump(config_clump *k, const sd_disk *disks, double (*arm)[2]);
/* Returns a disk in no clump as a rigid body, without force. */
static inline config_clump configuration_alone(const sd_disk *d) {
  config_clump body = {.mass = d->mass, .inertia = d->inertia};
  for (int q = 0; q < 3; q++) body.velocity[q] = d->velocity[q];
  for (int q = 0; q < 2; q++) body.position[q] = d->position[q];
  return body;
}
/* Computes normal, branch vector, point and force of a contact, and the numbers of its law, from
 * the members part, overlap, force, tau and roll, and from its disks a and b; b: NULL for wall
 * k->b - n_disks of c->model. */
void configuration_complete(const configuration *c, config_contact *k, const sd_disk *a,
                            const sd_disk *b);
/* Wraps a position into the periodic box. If rounding puts a coordinate on the upper edge, it is
 * set to the lower edge. */
void configuration_wrap(const configuration *c, double at[2]);
/* Returns true if the disk belongs to a clump. */
static inline bool configuration_in_clump(const configuration *c, size_t disk) {
  return c->n_clumps > 0 && c->clump_of[disk] >= 0;
}

/* Returns the region that is measured. wanted: x0, x1, y0, y1 of a region; NULL: the region of the
 * model, with edges that follow walls that have moved; the periodic box along periodic directions;
 * the bounding box of all disks if the model has no region. */
region configuration_region(const configuration *c, const double *wanted);
/* Returns a bit mask of those edges of the model's region that are neither walls nor periodic, so
 * that results per area depend on their position: bit 2 c is the lower, bit 2 c + 1 the upper edge
 * along coordinate c (0: x, 1: y). */
unsigned configuration_open(const configuration *c);
/* Returns the index of a body's material. */
int configuration_material(const sd_model *m, uint32_t body);
/* Returns the tangential force tau of stored contact c: the column contact_tau of the state if the
 * laws need it, else -k_t zeta; a zero is never -0. a, b: materials of the two bodies. */
static inline double configuration_tau_of(const sd_model *m, const sd_state *s, size_t c, int a,
                                          int b) {
  return 0.0 + (s->law_columns ? s->contact_tau[c]
                               : 0.0 - sd_model_law(m, a, b)->k_t * s->contact_zeta[c]);
}
/* Returns the tangential force tau of stored contact c. The materials are read from the state,
 * since the model of one rank lacks the disks of other ranks. */
static inline double configuration_tau(const sd_model *m, const sd_state *s,
                                       const slot_table *slots, size_t c) {
  return configuration_tau_of(m, s, c, s->material[slot_of(slots, s->contact_a[c])],
                              s->material[slot_of(slots, s->contact_b[c])]);
}
/* Returns true if the body is a free disk. */
bool configuration_is_free(const configuration *c, uint32_t body);
/* Computes the position at[] that point k of a wall has in this frame, after the wall's rotation
 * about its pivot and the pivot's motion. body: number of the wall among the bodies of the run. */
void configuration_wall_point(const sd_wall *wall, const frame_data *frame, size_t body, size_t k,
                              double at[2]);
/* Returns true if a disk of this activity is present: neither waiting nor removed. */
static inline bool activity_is_present(int32_t activity) {
  return activity == SD_IN_PLAY || activity == SD_OUTSIDE || activity == SD_HELD;
}
/* Replaces the difference d of two positions by that of the nearest periodic image. */
static inline void configuration_nearest(const configuration *c, double d[2]) {
  for (int k = 1; k >= 0; k--) {
    if (!(c->length[k] > 0.0)) continue;
    const double n = nearbyint(d[k] / c->length[k]);
    d[k] -= c->length[k] * n;
    if (k == 1) d[0] -= c->offset * n;
  }
}
/* Returns the mean radius of the disks, 0 without disks. */
double configuration_radius(const configuration *c);

#endif
