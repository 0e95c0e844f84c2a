#include "liggghts_fixes/run/petsc_session.h"

#include <petscsys.h>

#include <algorithm>
#include <cstdio>
#include <limits>
#include <stdexcept>

namespace twogrid {
namespace {

extern "C" int finalize_petsc(MPI_Comm, int, void*, void*) {
  PetscBool initialized = PETSC_FALSE, finalized = PETSC_FALSE;
  PetscInitialized(&initialized);
  PetscFinalized(&finalized);
  if (initialized && !finalized) PetscFinalize();
  return MPI_SUCCESS;
}

PetscErrorCode one_line(MPI_Comm, int line, const char* function, const char* file, PetscErrorCode code,
                        PetscErrorType type, const char* message, void*) {
  if (type == PETSC_ERROR_INITIAL)
    std::fprintf(stderr, "PETSc: %s (%s, %s:%d)\n", message ? message : "error", function ? function : "",
                 file ? file : "", line);
  return code;
}

}  // namespace

void start_petsc(const std::vector<std::string>& words) {
  // PETSc keeps pointers to the words until its end.
  static std::vector<std::string> copy;
  static std::vector<char*> pointers;
  copy = words;
  for (std::string& w : copy) pointers.push_back(w.data());
  pointers.push_back(nullptr);
  int argc = int(copy.size());
  char** argv = pointers.data();
  if (PetscInitialize(&argc, &argv, nullptr, nullptr)) throw std::runtime_error("PETSc could not be initialised");
  PetscPopSignalHandler();
  PetscPushErrorHandler(one_line, nullptr);

  int key = MPI_KEYVAL_INVALID;
  MPI_Comm_create_keyval(MPI_COMM_NULL_COPY_FN, finalize_petsc, &key, nullptr);
  MPI_Comm_set_attr(MPI_COMM_SELF, key, nullptr);
}

std::optional<std::array<int, 3>> fluid_bricks_option(int ranks) {
  PetscInt p[3] = {0, 0, 0}, n = 3;
  PetscBool given = PETSC_FALSE;
  PetscOptionsGetIntArray(nullptr, "fluid_", "-bricks", p, &n, &given);
  if (!given) return std::nullopt;
  if (n != 3 || p[0] < 1 || p[1] < 1 || p[2] < 1 || double(p[0]) * double(p[1]) * double(p[2]) != ranks)
    throw std::invalid_argument("-fluid_bricks: wanted three numbers of bricks, such as 1,1," + std::to_string(ranks) +
                                ", whose product is the number of ranks, " + std::to_string(ranks));
  return std::array<int, 3>{int(p[0]), int(p[1]), int(p[2])};
}

bool balance_option() {
  PetscBool on = PETSC_TRUE;
  if (PetscOptionsGetBool(nullptr, nullptr, "-balance", &on, nullptr))
    throw std::invalid_argument("-balance: wanted on or off after it");
  return on == PETSC_TRUE;
}

bool best_skin_option() {
  char word[16] = "script";
  PetscBool given = PETSC_FALSE;
  PetscOptionsGetString(nullptr, nullptr, "-skin", word, sizeof word, &given);
  const std::string skin = word;
  if (skin != "best" && skin != "script")
    throw std::invalid_argument("-skin: found '" + skin + "', wanted best or script after it");
  return skin == "best";
}

std::vector<std::string> UnusedOptions::sentences(const std::string& beginning, const std::string& but) {
  std::vector<std::string> found;
  PetscInt n = 0;
  char **names = nullptr, **values = nullptr;
  if (PetscOptionsLeftGet(nullptr, &n, &names, &values)) return found;
  for (PetscInt i = 0; i < n; ++i) {
    const std::string option = std::string("-") + names[i];
    if (option.rfind(beginning, 0) != 0 || (!but.empty() && option.rfind(but, 0) == 0)) continue;
    if (std::find(told_.begin(), told_.end(), option) != told_.end()) continue;
    told_.push_back(option);
    found.push_back("nothing has asked for the option " + option +
                    " of the command line: look how it is spelt (-fluid_pressure_..., -fluid_momentum_... and PETSc's "
                    "name after it), or take it out");
  }
  PetscOptionsLeftRestore(nullptr, &n, &names, &values);
  return found;
}

double most_cells() {
  return double(std::numeric_limits<PetscInt>::max());
}

std::string petsc_version() {
  return std::to_string(PETSC_VERSION_MAJOR) + "." + std::to_string(PETSC_VERSION_MINOR) + "." +
         std::to_string(PETSC_VERSION_SUBMINOR);
}

}  // namespace twogrid
