#include "liggghts_fixes/report/run_times.h"

#include "liggghts_fixes/report/progress.h"

namespace twogrid {

void RunTimes::begin(long long step, const Shares& so_far) {
  wall_ = MPI_Wtime();
  cpu_ = cpu_seconds();
  first_step_ = step;
  before_ = so_far;
  output_ = 0;
}

std::string RunTimes::text(MPI_Comm comm, const Shares& s) const {
  double sum[6] = {s.deposit - before_.deposit, s.map - before_.map, s.fluid - before_.fluid, output_,
                   s.force - before_.force,     cpu_seconds() - cpu_};
  MPI_Allreduce(MPI_IN_PLACE, sum, 6, MPI_DOUBLE, MPI_SUM, comm);
  return shares_text(MPI_Wtime() - wall_, sum[5], Shares{sum[0], sum[1], sum[2], sum[3], sum[4]});
}

}  // namespace twogrid
