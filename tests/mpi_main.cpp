// main() of the GoogleTest binaries: MPI and PETSc around the tests; every rank runs all tests, rank 0 reports; the exit
// code is non-zero if any rank failed.
#include <gtest/gtest.h>
#include <petscsys.h>

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  if (PetscInitialize(&argc, &argv, nullptr, nullptr)) return 2;
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank != 0)
    delete ::testing::UnitTest::GetInstance()->listeners().Release(
        ::testing::UnitTest::GetInstance()->listeners().default_result_printer());
  int bad = RUN_ALL_TESTS(), any = 0;
  MPI_Allreduce(&bad, &any, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  if (any && !bad && rank == 0) std::printf("a test failed on another rank than 0\n");
  PetscFinalize();
  return any;
}
