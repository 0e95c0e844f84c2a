#include "cfd/momentum/viscous_solver.h"

#include <cmath>
#include <sstream>

#include "cfd/pressure/petsc_wrappers.h"

namespace twogrid {

class ViscousSolver::Impl {
 public:
  Impl(MPI_Comm comm, const Boundaries& boundaries, const GridMeasures& measures, ViscousTerm& stress,
       const std::array<Box, 3>& faces, const Box& local, const FaceExchange& halo)
      : boundaries_(boundaries), measures_(measures), stress_(stress), faces_(faces), halo_(halo) {
    for (int d = 0; d < 3; ++d) {
      for (auto* f : {&work_, &force_, &diagonal_}) (*f)[d].reset(local);
      if (!boundaries.component_solved(d)) continue;
      for_each(faces[d], [&](int i, int j, int k) {
        if (boundaries.state(d)(i, j, k) == FaceState::kSolved) unknown_[d].push_back(int(work_[d].index(i, j, k)));
      });
    }
    const PetscInt n = PetscInt(unknown_[0].size() + unknown_[1].size() + unknown_[2].size());
    check(VecCreateMPI(comm, n, PETSC_DETERMINE, x_.put()));
    check(VecDuplicate(x_, b_.put()));
    check(MatCreateShell(comm, n, n, PETSC_DETERMINE, PETSC_DETERMINE, this, operator_.put()));
    check(MatShellSetOperation(operator_, MATOP_MULT, reinterpret_cast<void (*)(void)>(&Impl::multiply)));
    check(MatShellSetOperation(operator_, MATOP_GET_DIAGONAL, reinterpret_cast<void (*)(void)>(&Impl::get_diagonal)));
    check(KSPCreate(comm, solver_.put()));
    check(KSPSetOptionsPrefix(solver_, "fluid_momentum_"));
    // Not CG: at an outlet the transposed gradients make the operator unsymmetric, and CG may stall there.
    check(KSPSetType(solver_, KSPBCGS));
    check(KSPSetOperators(solver_, operator_, operator_));
    PC pc;
    check(KSPGetPC(solver_, &pc));
    check(PCSetType(pc, PCJACOBI));
    check(KSPSetTolerances(solver_, 1e-10, PETSC_DEFAULT, PETSC_DEFAULT, 2000));
    check(KSPSetFromOptions(solver_));
  }

  int solve(const Property& mu, const CellField<FineGrid>& eps, const FaceField<FineGrid>& inertia,
            const FaceField<FineGrid>& rhs, FaceField<FineGrid>& u) {
    mu_ = &mu, eps_ = &eps, inertia_ = &inertia;
    stress_.diagonal(mu, eps, diagonal_);
    // The residual of the guess, with the sides' own values, is the right-hand side for a correction that is zero
    // there.
    for (int d = 0; d < 3; ++d) work_[d] = u[d];
    apply(false);
    PetscScalar* b;
    check(VecGetArray(b_, &b));
    PetscInt q = 0;
    for (int d = 0; d < 3; ++d)
      for (int m : unknown_[d]) b[q++] = rhs[d].data()[m] - force_[d].data()[m];
    check(VecRestoreArray(b_, &b));
    check(VecZeroEntries(x_));
    // Else PETSc would go on with the diagonal of the first solve.
    check(MatAssemblyBegin(operator_, MAT_FINAL_ASSEMBLY));
    check(MatAssemblyEnd(operator_, MAT_FINAL_ASSEMBLY));
    check(KSPSolve(solver_, b_, x_));
    KSPConvergedReason reason;
    PetscInt iterations;
    check(KSPGetConvergedReason(solver_, &reason));
    check(KSPGetIterationNumber(solver_, &iterations));
    if (reason < 0) {
      std::ostringstream text;
      text << "the implicit viscosity did not converge in " << iterations << " iterations (PETSc reason " << int(reason)
           << "); wanted: convergence; lower 'dt' or raise -fluid_momentum_ksp_max_it";
      throw std::runtime_error(text.str());
    }
    const PetscScalar* x;
    check(VecGetArrayRead(x_, &x));
    q = 0;
    for (int d = 0; d < 3; ++d)
      for (int m : unknown_[d]) u[d].data()[m] += x[q++];
    check(VecRestoreArrayRead(x_, &x));
    return int(iterations);
  }

 private:
  /// force_ = A V w - integral of div(eps tau(w)) of w = work_.
  void apply(bool homogeneous) {
    halo_.bring(work_);
    boundaries_.apply(work_, homogeneous);
    for (auto& f : force_) f.fill(0);
    stress_.add(*mu_, *eps_, work_, force_);
    for (int d = 0; d < 3; ++d)
      for_each(faces_[d], [&](int i, int j, int k) {
        const std::ptrdiff_t m = work_[d].index(i, j, k);
        force_[d].data()[m] =
            (*inertia_)[d].data()[m] * measures_.volume(d, i, j, k) * work_[d].data()[m] - force_[d].data()[m];
      });
  }

  static PetscErrorCode multiply(Mat A, Vec x, Vec y) {
    Impl* self;
    PetscErrorCode code = MatShellGetContext(A, &self);
    if (code) return code;
    const PetscScalar* in;
    PetscScalar* out;
    if ((code = VecGetArrayRead(x, &in))) return code;
    PetscInt q = 0;
    for (int d = 0; d < 3; ++d) {
      self->work_[d].fill(0);
      for (int m : self->unknown_[d]) self->work_[d].data()[m] = in[q++];
    }
    if ((code = VecRestoreArrayRead(x, &in))) return code;
    self->apply(true);
    if ((code = VecGetArray(y, &out))) return code;
    q = 0;
    for (int d = 0; d < 3; ++d)
      for (int m : self->unknown_[d]) out[q++] = self->force_[d].data()[m];
    return VecRestoreArray(y, &out);
  }

  static PetscErrorCode get_diagonal(Mat A, Vec y) {
    Impl* self;
    PetscErrorCode code = MatShellGetContext(A, &self);
    if (code) return code;
    PetscScalar* out;
    if ((code = VecGetArray(y, &out))) return code;
    PetscInt q = 0;
    for (int d = 0; d < 3; ++d)
      for (int m : self->unknown_[d])
        out[q++] = self->diagonal_[d].data()[m] + (*self->inertia_)[d].data()[m] * self->volume_at(d, m);
    return VecRestoreArray(y, &out);
  }

  double volume_at(int d, int m) const {
    const Box& b = work_[d].box();
    const int i = b.lo[0] + m % b.size(0), j = b.lo[1] + (m / b.size(0)) % b.size(1);
    return measures_.volume(d, i, j, b.lo[2] + m / (b.size(0) * b.size(1)));
  }

  const Boundaries& boundaries_;
  const GridMeasures& measures_;
  ViscousTerm& stress_;
  std::array<Box, 3> faces_;
  const FaceExchange& halo_;
  std::array<std::vector<int>, 3> unknown_;  // memory indices of the solved own faces
  FaceField<FineGrid> work_, force_, diagonal_;
  const Property* mu_ = nullptr;
  const CellField<FineGrid>* eps_ = nullptr;
  const FaceField<FineGrid>* inertia_ = nullptr;
  PetscVector x_, b_;
  PetscMatrix operator_;
  PetscSolver solver_;
};

ViscousSolver::ViscousSolver(MPI_Comm comm, const Boundaries& boundaries, const GridMeasures& measures,
                             ViscousTerm& stress, const std::array<Box, 3>& faces, const Box& local,
                             const FaceExchange& halo)
    : impl_(std::make_unique<Impl>(comm, boundaries, measures, stress, faces, local, halo)) {}

ViscousSolver::~ViscousSolver() = default;

int ViscousSolver::solve(const Property& mu, const CellField<FineGrid>& eps, const FaceField<FineGrid>& inertia,
                         const FaceField<FineGrid>& rhs, FaceField<FineGrid>& u) {
  return impl_->solve(mu, eps, inertia, rhs, u);
}

}  // namespace twogrid
