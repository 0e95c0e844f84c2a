#include "coupling/output/wall_writer.h"

#include <algorithm>
#include <numeric>

#include "cfd/bodies/wall_stress.h"
#include "cfd/fluid/fluid.h"
#include "cfd/parallel/ranks.h"
#include "coupling/output/growing_file.h"

namespace twogrid {

namespace {

constexpr int kPolygon = 3;  // of XDMF's kinds of cells

std::vector<double> numbers(const std::vector<WallFacet>& facets, int components,
                            double (*value)(const WallFacet&, int)) {
  std::vector<double> out;
  for (const WallFacet& f : facets)
    for (int d = 0; d < components; ++d) out.push_back(value(f, d));
  return out;
}

/// All ranks' lists, one after the other, at rank 0.
std::vector<double> one_list(MPI_Comm comm, const std::vector<double>& own) {
  const int ranks = ranks_of(comm), count = int(own.size());
  std::vector<int> counts(ranks), places(ranks, 0);
  MPI_Gather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, comm);
  for (int r = 1; r < ranks; ++r) places[r] = places[r - 1] + counts[r - 1];
  std::vector<double> all(rank_of(comm) == 0 ? std::size_t(places.back()) + counts.back() : 0);
  MPI_Gatherv(own.data(), count, MPI_DOUBLE, all.data(), counts.data(), places.data(), MPI_DOUBLE, 0, comm);
  return all;
}

}  // namespace

WallWriter::WallWriter(MPI_Comm comm, const Fluid& fluid, const Settings& settings)
    : comm_(comm), rank_(rank_of(comm)), fluid_(fluid) {
  for (const Body& b : settings.fluid.bodies) names_.push_back(b.name);
  names_.resize(fluid.body_forces().size());
  if (!fluid.wall_stress()) return;
  sort_facets();
  if (settings.output.average_from >= 0 && has_surfaces())
    state_.sums.reset(fluid.layout().cells(rank_), WallMeansState::kSums);
}

void WallWriter::sort_facets() {
  const std::vector<WallFacet>& facets = fluid_.wall_stress()->facets();
  const Int3 n = fluid_.grid().n();
  std::vector<double> cell;
  double points = 0;
  for (const WallFacet& f : facets) {
    cell.push_back(f.cell[0] + double(n[0]) * (f.cell[1] + double(n[1]) * f.cell[2]));
    points += double(f.corners.size());
  }
  const std::vector<double> all = one_list(comm_, cell);
  order_.resize(all.size());
  std::iota(order_.begin(), order_.end(), std::size_t(0));
  std::sort(order_.begin(), order_.end(), [&](std::size_t a, std::size_t b) { return all[a] < all[b]; });
  double sums[2] = {double(facets.size()), points};
  MPI_Allreduce(MPI_IN_PLACE, sums, 2, MPI_DOUBLE, MPI_SUM, comm_);
  shown_.facets = (long long)(sums[0]), shown_.points = (long long)(sums[1]);
  shown_.topology = shown_.points + 2 * shown_.facets;
}

std::vector<double> WallWriter::gathered(const std::vector<double>& own, int components) const {
  const std::vector<double> all = one_list(comm_, own);
  std::vector<double> sorted(all.size());
  for (std::size_t q = 0; q < order_.size(); ++q)
    std::copy_n(all.begin() + std::ptrdiff_t(order_[q]) * components, components,
                sorted.begin() + std::ptrdiff_t(q) * components);
  return sorted;
}

void WallWriter::put(GrowingFile& file, const std::string& path, const std::vector<double>& own, int components,
                     const char* unit) const {
  const std::vector<double> all = gathered(own, components);
  std::vector<std::size_t> extent{std::size_t(shown_.facets)};
  if (components > 1) extent.push_back(std::size_t(components));
  file.replicated(path, all, extent, unit);
}

void WallWriter::put_at_rank_0(GrowingFile& file, const std::string& path, std::size_t rows,
                               const std::vector<int>& values) const {
  Slab s;
  s.extent = {rows}, s.offset = {0}, s.count = {rank_ == 0 ? rows : 0};
  file.slab(path, s, values.data());
}

double WallWriter::bytes_of_bodies() const {
  return names_.empty()
             ? 0
             : 24.0 * double(shown_.points) + 4.0 * double(shown_.topology) + 60.0 * double(shown_.facets) + 65536;
}

double WallWriter::bytes_of_frame() const {
  return names_.empty() ? 0 : 32.0 * double(shown_.facets) + 96.0 * double(names_.size()) + 16384;
}

void WallWriter::write_bodies(GrowingFile& file) const {
  if (names_.empty()) return;
  std::string all;
  std::vector<double> centres;
  for (const std::string& name : names_) all += (all.empty() ? "" : " ") + name;
  for (const BodyForce& b : fluid_.body_forces()) centres.insert(centres.end(), b.centre.begin(), b.centre.end());
  file.group("/grid/bodies");
  file.attribute("/grid/bodies", "names", all);
  file.replicated("/grid/bodies/centre", centres, {names_.size(), 3}, "m");
  if (!has_surfaces()) return;

  const std::vector<WallFacet>& facets = fluid_.wall_stress()->facets();
  const std::string at = "/grid/walls";
  file.group(at);
  put(file, at + "/area", numbers(facets, 1, [](const WallFacet& f, int) { return f.area; }), 1, "m2");
  put(file, at + "/normal", numbers(facets, 3, [](const WallFacet& f, int d) { return f.normal[d]; }), 3, "1");
  put(file, at + "/centre", numbers(facets, 3, [](const WallFacet& f, int d) { return f.centre[d]; }), 3, "m");
  const std::vector<double> body =
      gathered(numbers(facets, 1, [](const WallFacet& f, int) { return double(f.body); }), 1);
  put_at_rank_0(file, at + "/body", std::size_t(shown_.facets), {body.begin(), body.end()});
  // Lines around the facets, and where those of each begin.
  const std::vector<double> count =
      one_list(comm_, numbers(facets, 1, [](const WallFacet& f, int) { return double(f.corners.size()); }));
  std::vector<double> corners;
  for (const WallFacet& f : facets)
    for (const Vec3& p : f.corners) corners.insert(corners.end(), p.begin(), p.end());
  corners = one_list(comm_, corners);
  std::vector<std::size_t> begin(count.size() + 1, 0);
  for (std::size_t q = 0; q < count.size(); ++q) begin[q + 1] = begin[q] + std::size_t(count[q]);
  std::vector<double> points;
  std::vector<int> topology;
  for (std::size_t q : order_) {
    topology.insert(topology.end(), {kPolygon, int(count[q])});
    for (std::size_t p = begin[q]; p < begin[q + 1]; ++p) {
      topology.push_back(int(points.size() / 3));
      points.insert(points.end(), corners.begin() + std::ptrdiff_t(3 * p), corners.begin() + std::ptrdiff_t(3 * p + 3));
    }
  }
  file.replicated(at + "/points", points, {std::size_t(shown_.points), 3}, "m");
  put_at_rank_0(file, at + "/polygons", std::size_t(shown_.topology), topology);
}

XdmfSurface WallWriter::write_frame(GrowingFile& file, const std::string& name, double t, long step) const {
  if (names_.empty()) return {};
  std::vector<double> force, torque, friction;
  for (const BodyForce& b : fluid_.body_forces()) {
    const Vec3 f = b.force();
    force.insert(force.end(), f.begin(), f.end());
    torque.insert(torque.end(), b.torque.begin(), b.torque.end());
    friction.insert(friction.end(), b.friction.begin(), b.friction.end());
  }
  const std::string bodies = "/fluid/" + name + "/bodies", at = "/walls/" + name;
  file.group(bodies);
  file.replicated(bodies + "/force", force, {names_.size(), 3}, "N");
  file.replicated(bodies + "/torque", torque, {names_.size(), 3}, "N m");
  file.replicated(bodies + "/friction", friction, {names_.size(), 3}, "N");
  if (!has_surfaces()) return {};
  WallStress& stress = *fluid_.wall_stress();
  stress.take();
  std::vector<double> tau, p;
  for (std::size_t q = 0; q < stress.facets().size(); ++q) {
    const Vec3 f = stress.friction(q);
    tau.insert(tau.end(), f.begin(), f.end());
    p.push_back(stress.pressure(q));
  }
  file.group(at);
  file.replicated(at + "/time", {t}, {}, "s");
  file.replicated(at + "/step", {double(step)}, {});
  put(file, at + "/friction", tau, 3, "Pa");
  put(file, at + "/pressure", p, 1, "Pa");
  std::vector<double> sums;
  for (const auto& body : stress.sums())
    for (int d = 0; d < 3; ++d) sums.push_back(body[0][d] + body[1][d]);
  file.replicated(at + "/force", sums, {names_.size(), 3}, "N");
  return shown_;
}

void WallWriter::add(double weight) {
  if (!has_means()) return;
  WallStress& stress = *fluid_.wall_stress();
  stress.take();
  const Box& own = state_.sums.own();
  for (std::size_t q = 0; q < stress.facets().size(); ++q) {
    const WallFacet& f = stress.facets()[q];
    double* sum = state_.sums.at(CellTable<FineGrid>::place(own, f.cell[0], f.cell[1], f.cell[2]));
    const Vec3 tau = stress.friction(q);
    for (int d = 0; d < 3; ++d) sum[d] += weight * tau[d];
    sum[3] += weight * stress.pressure(q);
  }
  state_.weight += weight;
}

void WallWriter::begin_means_anew() {
  state_.weight = 0;
  std::fill(state_.sums.data(), state_.sums.data() + state_.sums.size(), 0.0);
}

void WallWriter::write_means(GrowingFile& file) const {
  if (!has_means() || !(state_.weight > 0)) return;
  std::vector<double> tau, p;
  for (const WallFacet& f : fluid_.wall_stress()->facets()) {
    const double* sum = state_.sums.at(CellTable<FineGrid>::place(state_.sums.own(), f.cell[0], f.cell[1], f.cell[2]));
    for (int d = 0; d < 3; ++d) tau.push_back(sum[d] / state_.weight);
    p.push_back(sum[3] / state_.weight);
  }
  file.group("/average/walls");
  file.attribute("/average/walls", "weight", state_.weight);
  put(file, "/average/walls/friction", tau, 3, "Pa");
  put(file, "/average/walls/pressure", p, 1, "Pa");
}

}  // namespace twogrid
