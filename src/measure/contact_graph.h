/* contact_graph.h: the graph of load-bearing contacts between rigid bodies, and what follows from
 * it that is no sum over contacts. */
#ifndef MEASURE_CONTACT_GRAPH_H
#define MEASURE_CONTACT_GRAPH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "slipdisk/status.h"

/* Node of a body that does not yield: a wall, or a disk that is prescribed */
#define GRAPH_FIXED UINT32_MAX

/* A load-bearing contact (F_n > 0). A clump is one node, that of one of its disks. */
typedef struct graph_edge {
  uint32_t a, b;
} graph_edge;

/* Finds rattlers: nodes with fewer than `least` load-bearing contacts are removed, and these
 * contacts with them, until all that are left have enough (`least` is 2, without friction 3).
 * left: [n_nodes] number of contacts that each node keeps; rattler: [n_nodes]. SD_ERROR_IO: out of
 * memory. */
sd_status graph_rattlers(size_t n_nodes, size_t n_edges, const graph_edge *edges, int least,
                         int32_t *left, bool *rattler);

/* Finds clusters of nodes that edges connect; fixed bodies connect nothing. root: [n_nodes] the
 * lowest node of the cluster of each node. */
void graph_clusters(size_t n_nodes, size_t n_edges, const graph_edge *edges, uint32_t *root);

#endif
