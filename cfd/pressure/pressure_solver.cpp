#include "cfd/pressure/pressure_solver.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "cfd/measures/row_measures.h"
#include "cfd/parallel/ranks.h"
#include "cfd/parallel/seven_point_halo.h"
#include "cfd/parallel/vectorised.h"
#include "cfd/pressure/multigrid.h"
#include "cfd/pressure/petsc_wrappers.h"

namespace twogrid {

namespace {
constexpr char kPrefix[] = "fluid_pressure_";

/// A row of own cells as far as it is open: memory index of its first cell, position in a Vec's local part, length.
struct OpenRow {
  std::ptrdiff_t m, v;
  int n;
};

/// y = -A x on rows: sum over faces of g (x_cell - x_neighbour). y has no halo.
TWOGRID_VECTORISED void apply_operator(const std::vector<OpenRow>& rows, const FaceField<FineGrid>& g,
                                       const Array3<double>& x, double* y_all) {
  const std::ptrdiff_t sy = x.stride(1), sz = x.stride(2);
  for (const OpenRow& row : rows) {
    const double *gx = g[0].data() + row.m, *gy = g[1].data() + row.m, *gz = g[2].data() + row.m, *a = x.data() + row.m;
    double* y = y_all + row.v;
#pragma GCC ivdep
    for (int i = 0; i < row.n; ++i) {
      const double c = a[i];
      y[i] = (gx[i] * (c - a[i - 1]) + gx[i + 1] * (c - a[i + 1])) +
             (gy[i] * (c - a[i - sy]) + gy[i + sy] * (c - a[i + sy])) +
             (gz[i] * (c - a[i - sz]) + gz[i + sz] * (c - a[i + sz]));
    }
  }
}

TWOGRID_VECTORISED void to_floats(const std::vector<OpenRow>& rows, double scale, const double* from, float* to) {
  for (const OpenRow& row : rows) {
    const double* in = from + row.v;
    float* __restrict out = to + row.m;
    for (int i = 0; i < row.n; ++i) out[i] = float(scale * in[i]);
  }
}

TWOGRID_VECTORISED void to_doubles(const std::vector<OpenRow>& rows, double scale, const float* from, double* to) {
  for (const OpenRow& row : rows) {
    const float* in = from + row.m;
    double* __restrict out = to + row.v;
    for (int i = 0; i < row.n; ++i) out[i] = scale * in[i];
  }
}

/// The power of two next above x, 1 if x is zero.
double power_of_two(double x) {
  int exponent = 0;
  std::frexp(x, &exponent);
  return x > 0 ? std::ldexp(1.0, exponent) : 1.0;
}
}  // namespace

class PressureSolver::Impl {
 public:
  Impl(MPI_Comm comm, const FineGrid& grid, const Layout& layout, double rtol, const Int3& halo, const OpenRows* open)
      : comm_(comm), grid_(grid), n_(grid.n()), open_(open), multigrid_(comm, grid, layout, narrowed(halo), open) {
    const int rank = rank_of(comm);
    own_ = layout.cells(rank);
    halo_ = SevenPointHalo(comm, layout.all_cells(), n_, grid.periodic(), halo);
    memory_ = own_.empty() ? Box{} : own_.grown(halo);
    const auto list = [&](const auto& like, std::vector<OpenRow>& to) {
      rows(like, [&](std::ptrdiff_t m, std::ptrdiff_t v, int n) {
        if (n > 0) to.push_back({m, v, n});
      });
    };
    list(Array3<char>(memory_), rows_);
    list(multigrid_.b(), multigrid_rows_);

    const PetscInt local = PetscInt(open ? open->count() : own_.count());
    check(VecCreateMPI(comm, local, PETSC_DETERMINE, solution_.put()));
    check(VecCreateMPIWithArray(comm, 1, local, PETSC_DETERMINE, nullptr, rhs_.put()));
    check(MatCreateShell(comm, local, local, PETSC_DETERMINE, PETSC_DETERMINE, this, matrix_.put()));
    check(MatShellSetOperation(matrix_, MATOP_MULT, reinterpret_cast<void (*)(void)>(&Impl::multiply)));
    check(MatSetOption(matrix_, MAT_SYMMETRIC, PETSC_TRUE));
    check(MatNullSpaceCreate(comm, PETSC_TRUE, 0, nullptr, constants_.put()));

    check(KSPCreate(comm, ksp_.put()));
    check(KSPSetOptionsPrefix(ksp_, kPrefix));
    check(KSPSetType(ksp_, KSPCG));
    check(KSPSetNormType(ksp_, KSP_NORM_UNPRECONDITIONED));
    check(KSPSetInitialGuessNonzero(ksp_, PETSC_TRUE));
    check(KSPSetOperators(ksp_, matrix_, matrix_));
    PC pc = nullptr;
    check(KSPGetPC(ksp_, &pc));
    check(PCSetType(pc, PCSHELL));
    check(PCShellSetName(pc, "semi-coarsening multigrid"));
    check(PCShellSetContext(pc, this));
    check(PCShellSetApply(pc, &Impl::precondition));
    PetscReal wanted = rtol;
    check(PetscOptionsGetReal(nullptr, kPrefix, "-rtol", &wanted, nullptr));
    check(KSPSetTolerances(ksp_, wanted, PETSC_DEFAULT, PETSC_DEFAULT, 300));
    check(KSPSetFromOptions(ksp_));
    check(KSPSetConvergenceTest(ksp_, &Impl::converged, this, nullptr));
  }

  double rtol() const {
    PetscReal r;
    check(KSPGetTolerances(ksp_, &r, nullptr, nullptr, nullptr));
    return r;
  }

  void set_operator(const FaceField<FineGrid>& conductance, bool singular) {
    for (int d = 0; d < 3; ++d) {
      g_store_[d].reset(memory_);
      if (own_.empty()) continue;
      Box faces = own_;
      if (!grid_.axis[d].periodic() && own_.hi[d] == n_[d]) ++faces.hi[d];
      copy_rows(conductance[d], g_store_[d], faces);
    }
    use_operator(g_store_, singular);
  }

  void set_operator(FaceField<FineGrid>& conductance, bool singular) {
    if (conductance[0].box() == memory_ && conductance[1].box() == memory_ && conductance[2].box() == memory_)
      use_operator(conductance, singular);
    else
      set_operator(static_cast<const FaceField<FineGrid>&>(conductance), singular);
  }

  void use_operator(FaceField<FineGrid>& g, bool singular) {
    g_ = &g;
    halo_.bring<double>({&g[0], &g[1], &g[2]});
    if (singular != singular_ || !known_) {
      check(MatSetNullSpace(matrix_, singular ? static_cast<MatNullSpace>(constants_) : nullptr));
      singular_ = singular;
      known_ = true;
    }
    // A power of two, for single precision's range only: it may stay what it was at first.
    if (!(typical_ > 0)) typical_ = typical_conductance();
    operator_scale_ = 1 / power_of_two(typical_);
    multigrid_.set_operator({&g[0], &g[1], &g[2]}, singular, operator_scale_);
  }

  double typical() const { return typical_; }
  void set_typical(double conductance) { typical_ = conductance; }

  int solve(const CellField<FineGrid>& b, CellField<FineGrid>& phi, double atol) {
    PetscInt local;
    check(VecGetLocalSize(solution_, &local));
    b_store_.resize(std::size_t(local));
    rows(b, [&](std::ptrdiff_t m, std::ptrdiff_t p, int n) { std::copy_n(b.data() + m, n, b_store_.data() + p); });
    return solve(b_store_.data(), phi, atol);
  }

  int solve(CellField<FineGrid>& b, CellField<FineGrid>& phi, double atol) {
    if (open_ || !(b.box() == own_)) return solve(static_cast<const CellField<FineGrid>&>(b), phi, atol);
    return solve(b.data(), phi, atol);
  }

 private:
  int solve(double* b, CellField<FineGrid>& phi, double atol) {
    check(VecPlaceArray(rhs_, b));
    int iterations = 0;
    try {
      iterations = solve_in_place(phi, atol);
    } catch (...) {
      VecResetArray(rhs_);
      throw;
    }
    check(VecResetArray(rhs_));
    return iterations;
  }

  int solve_in_place(CellField<FineGrid>& phi, double atol) {
    // The solver works with -A, which is positive definite.
    check(VecScale(rhs_, -1));
    load(phi, solution_);
    x_ = &phi;
    if (!(phi.box() == memory_)) {
      if (!(x_store_.box() == memory_)) x_store_.reset(memory_);
      x_ = &x_store_;
    }
    clear_beyond_sides(*x_);
    if (singular_) balance(atol);
    PetscReal abstol;
    check(KSPGetTolerances(ksp_, nullptr, &abstol, nullptr, nullptr));
    PetscReal norm;
    check(VecNorm(rhs_, NORM_2, &norm));
    if (!std::isfinite(norm))
      throw std::runtime_error(
          "the right-hand side of the pressure equation is not finite; reduce the time step (fix_modify cfl, or dt "
          "where it is given)");
    if (norm == 0) {
      check(VecSet(solution_, 0));
      store(phi);
      return 0;
    }
    target_ = std::max({rtol() * norm, double(abstol), atol});
    rhs_scale_ = 1 / power_of_two(norm);

    // A residual updated by recurrence drifts from the true one by round-off: where that matters the true residual is
    // checked after the solve, and the solve is started again from where it is.
    int iterations = 0;
    const bool delicate = target_ < 1e-8 * norm;
    for (int round = 0;; ++round) {
      check(KSPSolve(ksp_, rhs_, solution_));
      KSPConvergedReason reason;
      PetscInt its;
      check(KSPGetConvergedReason(ksp_, &reason));
      check(KSPGetIterationNumber(ksp_, &its));
      iterations += int(its);
      if (reason > 0 && !delicate) break;
      const double r = true_residual();
      if (r <= target_) break;
      const double floor = round_off(norm);
      if (r <= floor) break;
      if (round == 2 || !std::isfinite(r)) {
        std::ostringstream message;
        message << "the pressure solver stopped at a residual of " << r << " after " << iterations
                << " iterations (PETSc's reason " << int(reason) << "), wanted " << target_
                << "; loosen -fluid_pressure_rtol or reduce the time step (fix_modify cfl, or dt where it is given)";
        throw std::runtime_error(message.str());
      }
    }
    store(phi);
    return iterations;
  }

  /// At most one cell.
  static Int3 narrowed(const Int3& halo) { return {std::min(halo[0], 1), std::min(halo[1], 1), std::min(halo[2], 1)}; }

  static void copy_rows(const Array3<double>& from, Array3<double>& to, const Box& b) {
    for (int k = b.lo[2]; k < b.hi[2]; ++k)
      for (int j = b.lo[1]; j < b.hi[1]; ++j)
        std::copy_n(from.data() + from.index(b.lo[0], j, k), b.size(0), to.data() + to.index(b.lo[0], j, k));
  }

  /// Ghosts next to own cells: what an outlet couples to.
  void clear_beyond_sides(Array3<double>& x) const {
    if (own_.empty()) return;
    for (int d = 0; d < 3; ++d) {
      if (grid_.axis[d].periodic() || memory_.size(d) == own_.size(d)) continue;
      Box low = own_, high = own_;
      low.lo[d] = -1, low.hi[d] = own_.lo[d] == 0 ? 0 : -1;
      high.lo[d] = n_[d], high.hi[d] = own_.hi[d] == n_[d] ? n_[d] + 1 : n_[d];
      for (const Box& b : {low, high}) for_each(b, [&](int i, int j, int k) { x(i, j, k) = 0; });
    }
  }

  /// Largest conductance in the direction of most cells, of all ranks.
  double typical_conductance() const {
    const int d = int(std::max_element(n_.begin(), n_.end()) - n_.begin());
    double largest = 0;
    rows((*g_)[d], [&](std::ptrdiff_t m, std::ptrdiff_t, int n) {
      for (const double* g = (*g_)[d].data() + m; n > 0; --n, ++g) largest = std::max(largest, *g);
    });
    MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, comm_);
    return largest;
  }

  /// Calls f(memory index in a, position in a Vec's local part, length) for each row of own cells, as far as it is open.
  template <class A, class F>
  void rows(const A& a, F&& f) const {
    const int n = own_.size(0);
    std::ptrdiff_t v = 0;
    if (own_.empty()) return;
    for (int k = own_.lo[2]; k < own_.hi[2]; ++k)
      for (int j = own_.lo[1]; j < own_.hi[1]; ++j)
        if (!open_) {
          f(a.index(own_.lo[0], j, k), v, n), v += n;
        } else {
          const OpenRows::Part p = open_->at(j, k);
          f(a.index(p.begin, j, k), v, p.size()), v += p.size();
        }
  }

  void load(const CellField<FineGrid>& field, Vec to) const {
    PetscScalar* v = nullptr;
    check(VecGetArrayWrite(to, &v));
    const double* a = field.data();
    rows(field, [&](std::ptrdiff_t m, std::ptrdiff_t p, int n) { std::copy_n(a + m, n, v + p); });
    check(VecRestoreArrayWrite(to, &v));
  }

  /// Solution to the field; of a singular problem the one whose mean over the volume is zero.
  void store(CellField<FineGrid>& field) const {
    const PetscScalar* v = nullptr;
    check(VecGetArrayRead(solution_, &v));
    double sum[2] = {0, 0};
    if (singular_) {
      const PetscScalar* p = v;
      for_each_row(own_, open_, field, [&](const Int3& x, std::ptrdiff_t, int n) {
        for (int i = 0; i < n; ++i) {
          const double volume = grid_.volume(x[0] + i, x[1], x[2]);
          sum[0] += volume * *p++;
          sum[1] += volume;
        }
      });
      MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPI_DOUBLE, MPI_SUM, comm_);
    }
    const double mean = singular_ ? sum[0] / sum[1] : 0;
    double* a = field.data();
    rows(field, [&](std::ptrdiff_t m, std::ptrdiff_t p, int n) {
      for (int i = 0; i < n; ++i) a[m + i] = v[p + i] - mean;
    });
    check(VecRestoreArrayRead(solution_, &v));
  }

  /// Takes the mean out of a singular problem's right-hand side, or refuses if that would change the problem.
  void balance(double atol) const {
    PetscScalar sum;
    PetscReal absolute;
    PetscInt n;
    check(VecSum(rhs_, &sum));
    check(VecNorm(rhs_, NORM_1, &absolute));
    check(VecGetSize(rhs_, &n));
    if (std::abs(sum) > kImbalance * absolute && std::abs(sum) > atol * std::sqrt(double(n))) {
      std::ostringstream message;
      message << "inflow and outflow of a domain without a pressure boundary do not balance: their sum is " << sum
              << ", wanted at most " << kImbalance << " of " << absolute
              << "; give one side a pressure boundary (fix_modify boundary)";
      throw std::runtime_error(message.str());
    }
    check(VecShift(rhs_, -sum / n));
  }

  double true_residual() {
    if (!residual_) check(VecDuplicate(solution_, residual_.put()));
    check(MatMult(matrix_, solution_, residual_));
    check(VecAYPX(residual_, -1, rhs_));
    PetscReal norm;
    check(VecNorm(residual_, NORM_2, &norm));
    return norm;
  }

  /// Residual that rounding alone may leave: a few units in the last place of the terms that cancel in b - A x, that is
  /// of b and of diag(A) x.
  double round_off(double norm_b) const {
    const PetscScalar* v = nullptr;
    check(VecGetArrayRead(solution_, &v));
    double sum = 0;
    // A cell that is its own neighbour has no net flux.
    std::array<double, 3> on;
    for (int d = 0; d < 3; ++d) on[d] = grid_.axis[d].periodic() && n_[d] == 1 ? 0 : 1;
    const double *gx = (*g_)[0].data(), *gy = (*g_)[1].data(), *gz = (*g_)[2].data();
    const std::ptrdiff_t sy = x_->stride(1), sz = x_->stride(2);
    rows(*x_, [&](std::ptrdiff_t m, std::ptrdiff_t p, int n) {
      for (int i = 0; i < n; ++i, ++m) {
        const double t = (on[0] * gx[m] + on[0] * gx[m + 1] + on[1] * gy[m] + on[1] * gy[m + sy] + on[2] * gz[m] +
                          on[2] * gz[m + sz]) *
                         v[p + i];
        sum += t * t;
      }
    });
    check(VecRestoreArrayRead(solution_, &v));
    MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, comm_);
    return kRoundOff * PETSC_MACHINE_EPSILON * (norm_b + std::sqrt(sum));
  }

  static PetscErrorCode multiply(Mat matrix, Vec x, Vec y) {
    Impl* self = nullptr;
    PetscErrorCode error = MatShellGetContext(matrix, &self);
    if (error) return error;
    const PetscScalar* from = nullptr;
    PetscScalar* to = nullptr;
    if ((error = VecGetArrayRead(x, &from))) return error;
    double* a = self->x_->data();
    for (const OpenRow& row : self->rows_) std::copy_n(from + row.v, row.n, a + row.m);
    if ((error = VecRestoreArrayRead(x, &from))) return error;
    self->halo_.bring<double>({self->x_});
    if ((error = VecGetArrayWrite(y, &to))) return error;
    if (!self->own_.empty()) apply_operator(self->rows_, *self->g_, *self->x_, to);
    return VecRestoreArrayWrite(y, &to);
  }

  static PetscErrorCode precondition(PC pc, Vec r, Vec z) {
    Impl* self = nullptr;
    PetscErrorCode error = PCShellGetContext(pc, &self);
    if (error) return error;
    auto& mg = self->multigrid_;
    const PetscScalar* from = nullptr;
    PetscScalar* to = nullptr;
    if ((error = VecGetArrayRead(r, &from))) return error;
    // Both scaled by powers of two, so that single precision neither overflows nor vanishes.
    const double in = self->rhs_scale_, out = self->operator_scale_ / self->rhs_scale_;
    to_floats(self->multigrid_rows_, in, from, mg.b().data());
    if ((error = VecRestoreArrayRead(r, &from))) return error;
    mg.cycle();
    if ((error = VecGetArrayWrite(z, &to))) return error;
    to_doubles(self->multigrid_rows_, out, mg.x().data(), to);
    return VecRestoreArrayWrite(z, &to);
  }

  static PetscErrorCode converged(KSP ksp, PetscInt iteration, PetscReal norm, KSPConvergedReason* reason,
                                  void* context) {
    const Impl* self = static_cast<const Impl*>(context);
    PetscInt most;
    const PetscErrorCode error = KSPGetTolerances(ksp, nullptr, nullptr, nullptr, &most);
    *reason = !std::isfinite(norm)    ? KSP_DIVERGED_NANORINF
              : norm <= self->target_ ? KSP_CONVERGED_RTOL
              : iteration >= most     ? KSP_DIVERGED_ITS
                                      : KSP_CONVERGED_ITERATING;
    return error;
  }

  static constexpr double kImbalance = 1e-6;  // of the sum of |b|
  static constexpr double kRoundOff = 4;

  MPI_Comm comm_;
  FineGrid grid_;
  Int3 n_;
  Box own_;
  const OpenRows* open_;  // what the vectors hold of each row; null: all of it
  bool singular_ = false, known_ = false;
  double target_ = 0;                          // residual norm at which to stop
  double typical_ = 0;                         // conductance, of the first operator that has one
  double operator_scale_ = 1, rhs_scale_ = 1;  // factors on A and on residuals in the multigrid
  SevenPointHalo halo_;
  Box memory_;                        // of g_ and x_
  FaceField<FineGrid>* g_ = nullptr;  // the operator: the caller's, or the copy
  CellField<FineGrid>* x_ = nullptr;  // what is multiplied by it, with halo: the caller's phi, or a copy
  FaceField<FineGrid> g_store_;       // these three: only where the caller's arrays can't be used in place
  CellField<FineGrid> x_store_;
  std::vector<double> b_store_;
  std::vector<OpenRow> rows_, multigrid_rows_;  // in g_ and x_, in the multigrid's arrays
  Multigrid<float> multigrid_;  // a preconditioner: half the bytes, and rounding is put right by the iteration
  PetscVector rhs_, solution_;  // rhs_ is the caller's array
  PetscVector residual_;        // made when first needed
  PetscMatrix matrix_;
  PetscNullSpace constants_;
  PetscSolver ksp_;
};

PressureSolver::PressureSolver(MPI_Comm comm, const FineGrid& grid, const Layout& layout, double rtol, const Int3& halo,
                               const OpenRows* open)
    : impl_(std::make_unique<Impl>(comm, grid, layout, rtol, halo, open)) {}
PressureSolver::~PressureSolver() = default;

double PressureSolver::rtol() const {
  return impl_->rtol();
}

double PressureSolver::typical_conductance() const {
  return impl_->typical();
}

void PressureSolver::set_typical_conductance(double conductance) {
  impl_->set_typical(conductance);
}

void PressureSolver::set_operator(FaceField<FineGrid>& conductance, bool singular) {
  impl_->set_operator(conductance, singular);
}

void PressureSolver::set_operator(const FaceField<FineGrid>& conductance, bool singular) {
  impl_->set_operator(conductance, singular);
}

int PressureSolver::solve(CellField<FineGrid>& b, CellField<FineGrid>& phi, double atol) {
  return impl_->solve(b, phi, atol);
}

int PressureSolver::solve(const CellField<FineGrid>& b, CellField<FineGrid>& phi, double atol) {
  return impl_->solve(b, phi, atol);
}

}  // namespace twogrid
