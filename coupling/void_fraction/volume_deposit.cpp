#include "coupling/void_fraction/volume_deposit.h"

#include <algorithm>

#include "cfd/parallel/vectorised.h"
#include "coupling/two_grid/open_nodes.h"
#include "coupling/void_fraction/sphere_overlap.h"

namespace twogrid {

namespace {

Spread spread_of(Deposit kind) {
  switch (kind) {
    case Deposit::kTrilinear:
      return Spread::kLinear;
    case Deposit::kCube:
      return Spread::kCube;
    default:
      return Spread::kCell;
  }
}

}  // namespace

VolumeDeposit::VolumeDeposit(MPI_Comm comm, const ParticleGrid& grid, const Layout& nodes, const ParticleRegion& region,
                             Deposit kind, double cube_edge)
    : comm_(comm),
      grid_(grid),
      nodes_(nodes),
      region_(region),
      kind_(kind),
      cube_edge_(cube_edge),
      node_volume_(grid.largest_volume()) {
  if (kind_ != Deposit::kExact) make_window();  // else the radius isn't known yet
}

void VolumeDeposit::make_window() {
  const double width = kind_ == Deposit::kExact ? 2 * radius_ : kind_ == Deposit::kCube ? cube_edge_ : 0.0;
  window_ = Window(comm_, grid_, nodes_, region_, spread_of(kind_), width);
  sum_.reset(window_.box());
}

void VolumeDeposit::move_region(const ParticleRegion& region) {
  region_ = region;
  if (kind_ != Deposit::kExact || radius_ > 0) make_window();
}

void VolumeDeposit::prepare(double largest_radius) {
  const double sphere = sphere_volume(largest_radius);
  scale_ = FixedPoint(sphere, sphere > 0 ? 15 * std::max(node_volume_ / sphere, 1.0) : 1.0);
  if (kind_ != Deposit::kExact || (largest_radius <= radius_ && radius_ > 0)) return;
  radius_ = largest_radius;
  make_window();
}

namespace {

TWOGRID_VECTORISED void add_at_corners(const Particles& p, const std::vector<int>& who, const Corners* corners,
                                       const WindowShape& window, const FixedPoint& scale, long long* sum) {
  const WindowShape shape = window;
  for (std::size_t q = 0; q < who.size(); ++q)
    scatter(corners[q], shape, scale.whole(sphere_volume(p.radius[who[q]])), sum);
}

TWOGRID_VECTORISED void add_at_centres(const Particles& p, const std::vector<int>& who, const std::ptrdiff_t* node,
                                       const FixedPoint& scale, long long* sum) {
  for (std::size_t q = 0; q < who.size(); ++q) sum[node[q]] += scale.quantise(sphere_volume(p.radius[who[q]]));
}

}  // namespace

void VolumeDeposit::operator()(const Particles& p, const std::vector<int>& who, Array3<long long>& volume,
                               const Places* places) {
  sum_.fill(0);
  if (!places && (kind_ == Deposit::kCentroid || kind_ == Deposit::kTrilinear)) {
    find_places(window_, p, who, places_);
    places = &places_;
  }
  switch (kind_) {
    case Deposit::kCentroid:
      add_at_centres(p, who, places->node.data(), scale_, sum_.data());
      break;
    case Deposit::kTrilinear:
      if (window_.cut())
        add_seen(p, who);
      else
        add_at_corners(p, who, places->corners.data(), window_.shape(), scale_, sum_.data());
      break;
    case Deposit::kExact:
      for (int i : who) intersect_sphere(p.x[i], p.radius[i], scale_.quantise(sphere_volume(p.radius[i])));
      break;
    case Deposit::kCube: {
      if (window_.cut()) {
        add_seen(p, who);
        break;
      }
      Stencil s;
      for (int i : who) {
        window_.weights(p.x[i], s);
        scatter(s, scale_.quantise(sphere_volume(p.radius[i])), sum_);
      }
      break;
    }
  }
  volume.fill(0);
  window_.add({&sum_}, {&volume});
  if (const OpenNodes* open = grid_.open_nodes()) open->gather_up(slot_of(volume));
}

void VolumeDeposit::add_seen(const Particles& p, const std::vector<int>& who) {
  const WindowShape shape = window_.shape();
  for (int i : who) {
    window_.see(p.x[i], seen_);
    scatter(seen_, shape, scale_.whole(sphere_volume(p.radius[i])), sum_.data());
  }
}

void VolumeDeposit::intersect_sphere(const double x[3], double radius, long long total) {
  // Nodes touched and the planes between them, scaled to the unit ball. Only planes between two nodes cut: what lies
  // beyond the outermost node of the grid stays with it.
  Int3 lo, n;
  double cut[3][Stencil::kMax + 1];
  for (int d = 0; d < 3; ++d) {
    const Window::Span& a = window_.span(d);
    lo[d] = a.find(x[d] - radius);
    n[d] = a.find(x[d] + radius) - lo[d] + 1;
    for (int i = 1; i < n[d]; ++i) cut[d][i] = (a.low(lo[d] + i) - x[d]) / radius;
  }
  const std::ptrdiff_t first = sum_.index(lo[0], lo[1], lo[2]);
  const std::ptrdiff_t* place = nullptr;  // of the nodes touched; null: their own
  if (window_.cut()) {
    const std::ptrdiff_t own = window_.node(x), home = window_.open_node(x);
    if (home != own) {
      sum_.data()[home] += total;
      return;
    }
    window_.seen_from({window_.span(0).find(x[0]), window_.span(1).find(x[1]), window_.span(2).find(x[2])}, lo, n,
                      seen_.at);
    place = seen_.at.data();
  }
  if (n[0] * n[1] * n[2] == 1) {
    sum_.data()[first] += total;
    return;
  }
  // beyond(i,j,k): volume with x > cut[0][i], ...; plane 0 lies at minus infinity, plane n at plus infinity.
  const int row = n[0] + 1, slab = row * (n[1] + 1);
  beyond_.assign(std::size_t(slab) * (n[2] + 1), 0.0);
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i) {
        double& v = beyond_[i + row * j + slab * k];
        const int cuts = (i > 0) + 2 * (j > 0) + 4 * (k > 0);
        switch (cuts) {
          case 0:
            v = ball_beyond(-1.0);
            break;
          case 1:
            v = ball_beyond(cut[0][i]);
            break;
          case 2:
            v = ball_beyond(cut[1][j]);
            break;
          case 3:
            v = ball_beyond(cut[0][i], cut[1][j]);
            break;
          case 4:
            v = ball_beyond(cut[2][k]);
            break;
          case 5:
            v = ball_beyond(cut[0][i], cut[2][k]);
            break;
          case 6:
            v = ball_beyond(cut[1][j], cut[2][k]);
            break;
          default:
            v = ball_beyond(cut[0][i], cut[1][j], cut[2][k]);
        }
      }
  const double share = double(total) / ball_beyond(-1.0);
  long long rest = total;
  double largest = -1;
  std::ptrdiff_t at = first;
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i) {
        const double* b = &beyond_[i + row * j + slab * k];
        const double v =
            ((b[0] - b[1]) - (b[row] - b[row + 1])) - ((b[slab] - b[slab + 1]) - (b[slab + row] - b[slab + row + 1]));
        if (v <= 0) continue;
        const long long part = static_cast<long long>(v * share);
        const std::ptrdiff_t m = place ? place[i + n[0] * (j + n[1] * k)] : sum_.index(lo[0] + i, lo[1] + j, lo[2] + k);
        sum_.data()[m] += part;
        rest -= part;
        if (v > largest) largest = v, at = m;
      }
  sum_.data()[at] += rest;
}

}  // namespace twogrid
