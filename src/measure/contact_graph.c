/* contact_graph.c: implements contact_graph.h. */
#include "measure/contact_graph.h"

#include <stdlib.h>

#include "base/memory.h"

/* Neighbours of all nodes: those of node i have the indices start[i] ... start[i + 1] - 1. */
typedef struct neighbour_lists {
  size_t *start;
  uint32_t *node;
  uint32_t *stack; /* rattlers whose contacts are still to be taken from their neighbours */
} neighbour_lists;

static void list_neighbours(neighbour_lists *l, size_t n_nodes, size_t n_edges,
                            const graph_edge *edges, const int32_t *count) {
  for (size_t i = 0; i < n_nodes; i++) l->start[i + 2] = l->start[i + 1] + (size_t)count[i];
  for (size_t k = 0; k < n_edges; k++) {
    const graph_edge *q = &edges[k];
    if (q->a != GRAPH_FIXED) l->node[l->start[q->a + 1]++] = q->b;
    if (q->b != GRAPH_FIXED) l->node[l->start[q->b + 1]++] = q->a;
  }
}

static void prune(const neighbour_lists *l, size_t n_nodes, int least, int32_t *left,
                  bool *rattler) {
  size_t waiting = 0;
  for (uint32_t i = 0; i < n_nodes; i++) {
    rattler[i] = left[i] < least;
    if (rattler[i]) l->stack[waiting++] = i;
  }
  while (waiting > 0) {
    const uint32_t i = l->stack[--waiting];
    for (size_t k = l->start[i]; k < l->start[i + 1]; k++) {
      const uint32_t b = l->node[k];
      if (b == GRAPH_FIXED || rattler[b] || --left[b] >= least) continue;
      rattler[b] = true;
      l->stack[waiting++] = b;
    }
  }
}

sd_status graph_rattlers(size_t n_nodes, size_t n_edges, const graph_edge *edges, int least,
                         int32_t *left, bool *rattler) {
  neighbour_lists l;
  if (!memory_rows(3, (memory_column[]){{&l.start, n_nodes + 2, sizeof *l.start},
                                        {&l.node, 2 * n_edges, sizeof *l.node},
                                        {&l.stack, n_nodes, sizeof *l.stack}}))
    return SD_ERROR_IO;
  for (size_t i = 0; i < n_nodes; i++) left[i] = 0;
  for (size_t k = 0; k < n_edges; k++) {
    if (edges[k].a != GRAPH_FIXED) left[edges[k].a]++;
    if (edges[k].b != GRAPH_FIXED) left[edges[k].b]++;
  }
  list_neighbours(&l, n_nodes, n_edges, edges, left);
  prune(&l, n_nodes, least, left, rattler);
  free(l.start);
  free(l.node);
  free(l.stack);
  return SD_OK;
}

/* Returns the root of a node, and shortens the way to it. */
static uint32_t root_of(uint32_t *parent, uint32_t node) {
  while (parent[node] != node) node = parent[node] = parent[parent[node]];
  return node;
}

void graph_clusters(size_t n_nodes, size_t n_edges, const graph_edge *edges, uint32_t *root) {
  for (uint32_t i = 0; i < n_nodes; i++) root[i] = i;
  for (size_t k = 0; k < n_edges; k++) {
    if (edges[k].a == GRAPH_FIXED || edges[k].b == GRAPH_FIXED) continue;
    const uint32_t a = root_of(root, edges[k].a), b = root_of(root, edges[k].b);
    root[a < b ? b : a] = a < b ? a : b;
  }
  for (uint32_t i = 0; i < n_nodes; i++) root[i] = root_of(root, i);
}
