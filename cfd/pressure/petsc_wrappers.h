// PETSc objects that destroy themselves, and one check() of PETSc's return codes.
#pragma once

#include <petscksp.h>

#include <stdexcept>
#include <string>
#include <utility>

namespace twogrid {

/// Throws std::runtime_error with PETSc's text when a call failed.
inline void check(PetscErrorCode code) {
  if (code == 0) return;
  const char* text = nullptr;
  PetscErrorMessage(code, &text, nullptr);
  throw std::runtime_error("PETSc failed: " + std::string(text ? text : "unknown error") + " (code " +
                           std::to_string(int(code)) + ")");
}

/// Owner of one PETSc object. Destruction is collective, as in PETSc; after PetscFinalize it does nothing.
template <class T, PetscErrorCode (*Destroy)(T*)>
class PetscOwner {
 public:
  PetscOwner() = default;
  PetscOwner(const PetscOwner&) = delete;
  PetscOwner& operator=(const PetscOwner&) = delete;
  ~PetscOwner() { reset(); }

  operator T() const { return object_; }
  /// For PETSc's create functions.
  T* put() {
    reset();
    return &object_;
  }
  void reset() {
    PetscBool finalized = PETSC_FALSE;
    PetscFinalized(&finalized);
    if (object_ && !finalized) Destroy(&object_);
    object_ = nullptr;
  }

 private:
  T object_ = nullptr;
};

using PetscVector = PetscOwner<Vec, VecDestroy>;
using PetscMatrix = PetscOwner<Mat, MatDestroy>;
using PetscSolver = PetscOwner<KSP, KSPDestroy>;
using PetscNullSpace = PetscOwner<MatNullSpace, MatNullSpaceDestroy>;

}  // namespace twogrid
