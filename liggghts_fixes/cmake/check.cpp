// Does a library fit? libraries.cmake compiles and links parts of this and shows the sentences after "twogrid: ".
#include <mpi.h>

#ifdef CHECK_PETSC
#include <petscksp.h>
#if defined(PETSC_USE_COMPLEX)
#error "twogrid: its numbers are complex (--with-scalar-type=complex); one with real numbers is wanted"
#elif !defined(PETSC_USE_REAL_DOUBLE)
#error "twogrid: its numbers are not of double precision; one built with --with-precision=double is wanted"
#elif PETSC_VERSION_LT(3, 12, 0)
#error "twogrid: it is too old; 3.12 or newer is wanted"
#endif
int main(int argc, char** argv) {
  PetscInitialize(&argc, &argv, nullptr, nullptr);
  KSP solver;
  KSPCreate(PETSC_COMM_WORLD, &solver);
}
#endif

#ifdef CHECK_HDF5
#include <hdf5.h>
#if !defined(H5_HAVE_PARALLEL)
#error \
    "twogrid: it was built without MPI, and all ranks write one file; one built with --enable-parallel (-DHDF5_ROOT=FOLDER) is wanted"
#elif !H5_VERSION_GE(1, 10, 0)
#error "twogrid: it is too old; 1.10 or newer is wanted"
#endif
int main() {
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  H5Pset_fapl_mpio(access, MPI_COMM_WORLD, MPI_INFO_NULL);
  return H5Pset_coll_metadata_write(access, true);
}
#endif

#ifdef CHECK_LIGGGHTS
#include <domain.h>
#include <lammps.h>
#include <modify.h>
#ifdef CHECK_SUPERQUADRIC
#include <atom_vec_superquadric.h>
#endif
// The names that the linker looks for tell kind of communicator and width of integers.
int main(int argc, char** argv) {
  LAMMPS_NS::LAMMPS lammps(argc, argv, MPI_COMM_WORLD);
  lammps.modify->addstep_compute(LAMMPS_NS::bigint(0));
  lammps.domain->unmap(nullptr, LAMMPS_NS::tagint(0));
#ifdef CHECK_SUPERQUADRIC
  LAMMPS_NS::AtomVecSuperquadric vector(&lammps);
#endif
}
#endif

#ifdef CHECK_ALL
#include <H5public.h>
#include <petscsys.h>
// By name only: LIGGGHTS' headers are not looked at again.
namespace LAMMPS_NS {
class LAMMPS {
 public:
  LAMMPS(int, char**, MPI_Comm);
};
}  // namespace LAMMPS_NS
int main(int argc, char** argv) {
  PetscInitialize(&argc, &argv, nullptr, nullptr);
  H5open();
  new LAMMPS_NS::LAMMPS(argc, argv, MPI_COMM_WORLD);
}
#endif
