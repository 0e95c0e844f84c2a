/* Counts what an MPI program sends, for LD_PRELOAD: messages to other ranks and their bytes, collective calls and the
 * bytes a rank hands to them, kept apart by the chain of callers. At MPI_Finalize every rank writes $MPI_COUNT.RANK, a
 * line a chain: kind calls bytes object+offset object+offset ...        (kind: p2p or collective; innermost caller
 * first) traffic.py beside this gives the chains names. Without $MPI_COUNT nothing is counted. Messages to oneself and
 * to MPI_PROC_NULL are none. One-sided communication and MPI's own files are not counted. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <execinfo.h>
#include <mpi.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { kDepth = 40, kChains = 1 << 14, kRequests = 1 << 12 };
enum { kNone, kP2p, kCollective };

struct Chain {
  int kind, depth;
  void* frame[kDepth];
  long long calls, bytes;
};
static struct Chain chains[kChains];
static int on = -1;

/* Persistent sends: what MPI_Start will send. */
static struct {
  MPI_Request request;
  long long bytes;
} persistent[kRequests];

static void count(int kind, long long bytes) {
  if (on < 0) on = getenv("MPI_COUNT") != NULL;
  if (!on) return;
  void* frame[kDepth + 2];
  const int depth = backtrace(frame, kDepth + 2) - 2; /* without count() and the wrapper */
  uint64_t h = kind;
  for (int i = 0; i < depth; ++i) h = (h ^ (uintptr_t)frame[i + 2]) * 0x9E3779B97F4A7C15u, h ^= h >> 29;
  for (int n = 0; n < kChains; ++n) {
    struct Chain* c = &chains[(h + n) % kChains];
    if (c->kind == kNone) {
      c->kind = kind;
      c->depth = depth;
      memcpy(c->frame, frame + 2, depth * sizeof frame[0]);
    }
    if (c->kind != kind || c->depth != depth || memcmp(c->frame, frame + 2, depth * sizeof frame[0])) continue;
    c->calls += 1;
    c->bytes += bytes;
    return;
  }
  fprintf(stderr, "mpi_count: more than %d chains of callers\n", kChains);
  PMPI_Abort(MPI_COMM_WORLD, 1);
}

static long long size_of(long long n, MPI_Datatype type) {
  int size;
  PMPI_Type_size(type, &size);
  return n * size;
}

static int to_another(int rank, MPI_Comm comm) {
  int me;
  PMPI_Comm_rank(comm, &me);
  return rank != MPI_PROC_NULL && rank != me;
}

#define SEND(name, handle, pass)                                                                       \
  int MPI_##name(const void* buf, int n, MPI_Datatype type, int dest, int tag, MPI_Comm comm handle) { \
    if (to_another(dest, comm)) count(kP2p, size_of(n, type));                                         \
    return PMPI_##name pass;                                                                           \
  }
#define REQUEST , MPI_Request* request
SEND(Send, , (buf, n, type, dest, tag, comm))
SEND(Ssend, , (buf, n, type, dest, tag, comm))
SEND(Rsend, , (buf, n, type, dest, tag, comm))
SEND(Bsend, , (buf, n, type, dest, tag, comm))
SEND(Isend, REQUEST, (buf, n, type, dest, tag, comm, request))
SEND(Issend, REQUEST, (buf, n, type, dest, tag, comm, request))
SEND(Irsend, REQUEST, (buf, n, type, dest, tag, comm, request))
SEND(Ibsend, REQUEST, (buf, n, type, dest, tag, comm, request))

int MPI_Sendrecv(const void* buf, int n, MPI_Datatype type, int dest, int tag, void* rbuf, int rn, MPI_Datatype rtype,
                 int source, int rtag, MPI_Comm comm, MPI_Status* status) {
  if (to_another(dest, comm)) count(kP2p, size_of(n, type));
  return PMPI_Sendrecv(buf, n, type, dest, tag, rbuf, rn, rtype, source, rtag, comm, status);
}

int MPI_Sendrecv_replace(void* buf, int n, MPI_Datatype type, int dest, int tag, int source, int rtag, MPI_Comm comm,
                         MPI_Status* status) {
  if (to_another(dest, comm)) count(kP2p, size_of(n, type));
  return PMPI_Sendrecv_replace(buf, n, type, dest, tag, source, rtag, comm, status);
}

static void remember(MPI_Request request, long long bytes) {
  for (int i = 0; i < kRequests; ++i)
    if (!persistent[i].request || persistent[i].request == request) {
      persistent[i].request = request;
      persistent[i].bytes = bytes;
      return;
    }
}

int MPI_Send_init(const void* buf, int n, MPI_Datatype type, int dest, int tag, MPI_Comm comm, MPI_Request* request) {
  const int result = PMPI_Send_init(buf, n, type, dest, tag, comm, request);
  remember(*request, to_another(dest, comm) ? size_of(n, type) : -1);
  return result;
}

static void started(MPI_Request request) {
  for (int i = 0; i < kRequests && persistent[i].request; ++i)
    if (persistent[i].request == request && persistent[i].bytes >= 0) count(kP2p, persistent[i].bytes);
}

int MPI_Start(MPI_Request* request) {
  started(*request);
  return PMPI_Start(request);
}

int MPI_Startall(int n, MPI_Request request[]) {
  for (int i = 0; i < n; ++i) started(request[i]);
  return PMPI_Startall(n, request);
}

/* Neighbourhood collectives are messages to the neighbours. */
int MPI_Neighbor_alltoallv(const void* s, const int n[], const int at[], MPI_Datatype type, void* r, const int rn[],
                           const int rat[], MPI_Datatype rtype, MPI_Comm comm) {
  int in, out, weighted;
  PMPI_Dist_graph_neighbors_count(comm, &in, &out, &weighted);
  for (int i = 0; i < out; ++i) count(kP2p, size_of(n[i], type));
  return PMPI_Neighbor_alltoallv(s, n, at, type, r, rn, rat, rtype, comm);
}

int MPI_Ineighbor_alltoallv(const void* s, const int n[], const int at[], MPI_Datatype type, void* r, const int rn[],
                            const int rat[], MPI_Datatype rtype, MPI_Comm comm, MPI_Request* request) {
  int in, out, weighted;
  PMPI_Dist_graph_neighbors_count(comm, &in, &out, &weighted);
  for (int i = 0; i < out; ++i) count(kP2p, size_of(n[i], type));
  return PMPI_Ineighbor_alltoallv(s, n, at, type, r, rn, rat, rtype, comm, request);
}

#define COLLECTIVE(name, parameters, bytes, pass) \
  int MPI_##name parameters {                     \
    count(kCollective, bytes);                    \
    return PMPI_##name pass;                      \
  }
COLLECTIVE(Barrier, (MPI_Comm comm), 0, (comm))
COLLECTIVE(Ibarrier, (MPI_Comm comm, MPI_Request* r), 0, (comm, r))
COLLECTIVE(Allreduce, (const void* s, void* r, int n, MPI_Datatype t, MPI_Op op, MPI_Comm comm), size_of(n, t),
           (s, r, n, t, op, comm))
COLLECTIVE(Iallreduce, (const void* s, void* r, int n, MPI_Datatype t, MPI_Op op, MPI_Comm comm, MPI_Request* q),
           size_of(n, t), (s, r, n, t, op, comm, q))
COLLECTIVE(Reduce, (const void* s, void* r, int n, MPI_Datatype t, MPI_Op op, int root, MPI_Comm comm), size_of(n, t),
           (s, r, n, t, op, root, comm))
COLLECTIVE(Bcast, (void* b, int n, MPI_Datatype t, int root, MPI_Comm comm), size_of(n, t), (b, n, t, root, comm))
COLLECTIVE(Scan, (const void* s, void* r, int n, MPI_Datatype t, MPI_Op op, MPI_Comm comm), size_of(n, t),
           (s, r, n, t, op, comm))
COLLECTIVE(Exscan, (const void* s, void* r, int n, MPI_Datatype t, MPI_Op op, MPI_Comm comm), size_of(n, t),
           (s, r, n, t, op, comm))
COLLECTIVE(Gather, (const void* s, int n, MPI_Datatype t, void* r, int rn, MPI_Datatype rt, int root, MPI_Comm comm),
           size_of(n, t), (s, n, t, r, rn, rt, root, comm))
COLLECTIVE(Gatherv,
           (const void* s, int n, MPI_Datatype t, void* r, const int rn[], const int at[], MPI_Datatype rt, int root,
            MPI_Comm comm),
           size_of(n, t), (s, n, t, r, rn, at, rt, root, comm))
COLLECTIVE(Allgather, (const void* s, int n, MPI_Datatype t, void* r, int rn, MPI_Datatype rt, MPI_Comm comm),
           size_of(n, t), (s, n, t, r, rn, rt, comm))
COLLECTIVE(Allgatherv,
           (const void* s, int n, MPI_Datatype t, void* r, const int rn[], const int at[], MPI_Datatype rt,
            MPI_Comm comm),
           size_of(n, t), (s, n, t, r, rn, at, rt, comm))
COLLECTIVE(Alltoall, (const void* s, int n, MPI_Datatype t, void* r, int rn, MPI_Datatype rt, MPI_Comm comm),
           size_of(n, t), (s, n, t, r, rn, rt, comm))
COLLECTIVE(Reduce_scatter, (const void* s, void* r, const int rn[], MPI_Datatype t, MPI_Op op, MPI_Comm comm),
           size_of(rn[0], t), (s, r, rn, t, op, comm))
COLLECTIVE(Reduce_scatter_block, (const void* s, void* r, int n, MPI_Datatype t, MPI_Op op, MPI_Comm comm),
           size_of(n, t), (s, r, n, t, op, comm))
COLLECTIVE(Scatter, (const void* s, int n, MPI_Datatype t, void* r, int rn, MPI_Datatype rt, int root, MPI_Comm comm),
           size_of(rn, rt), (s, n, t, r, rn, rt, root, comm))
COLLECTIVE(Scatterv,
           (const void* s, const int n[], const int at[], MPI_Datatype t, void* r, int rn, MPI_Datatype rt, int root,
            MPI_Comm comm),
           size_of(rn, rt), (s, n, at, t, r, rn, rt, root, comm))

int MPI_Alltoallv(const void* s, const int n[], const int at[], MPI_Datatype t, void* r, const int rn[],
                  const int rat[], MPI_Datatype rt, MPI_Comm comm) {
  int ranks;
  long long sum = 0;
  PMPI_Comm_size(comm, &ranks);
  for (int i = 0; i < ranks; ++i) sum += n[i];
  count(kCollective, size_of(sum, t));
  return PMPI_Alltoallv(s, n, at, t, r, rn, rat, rt, comm);
}

static void write_chains(void) {
  const char* prefix = getenv("MPI_COUNT");
  if (!prefix) return;
  int me;
  char name[4096];
  PMPI_Comm_rank(MPI_COMM_WORLD, &me);
  snprintf(name, sizeof name, "%s.%d", prefix, me);
  FILE* f = fopen(name, "w");
  if (!f) return;
  for (int i = 0; i < kChains; ++i) {
    const struct Chain* c = &chains[i];
    if (c->kind == kNone) continue;
    fprintf(f, "%s %lld %lld", c->kind == kP2p ? "p2p" : "collective", c->calls, c->bytes);
    for (int k = 0; k < c->depth; ++k) {
      Dl_info info;
      if (dladdr(c->frame[k], &info) && info.dli_fname)
        fprintf(f, " %s+%lx", info.dli_fname, (unsigned long)((char*)c->frame[k] - (char*)info.dli_fbase));
    }
    fputc('\n', f);
  }
  fclose(f);
}

int MPI_Finalize(void) {
  write_chains();
  return PMPI_Finalize();
}
