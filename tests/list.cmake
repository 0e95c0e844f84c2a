# The tests, by name.

# Unit tests run whole on 1, 2, 4 and 8 ranks: what they check may not depend on the ranks.
twogrid_test(NAME unit RANKS 1 2 4 8 TIMEOUT 200 LABELS unit COMMAND $<TARGET_FILE:unit_tests>)
twogrid_test(NAME verification RANKS 1 TIMEOUT 900 LABELS verification COMMAND $<TARGET_FILE:verification_tests>)
# The orders of convergence don't depend on the ranks; the flows do not either, to the solver's tolerance.
twogrid_test(NAME verification_flows RANKS 2 4 TIMEOUT 400 LABELS verification
             COMMAND $<TARGET_FILE:verification_tests> --gtest_filter=-Manufactured.*:Cavity.*:StretchedGrid.*)

# system_test(name [FOLDER folder] [TIMEOUT s] [RANKS n...]): tests/folder/name.py EXECUTABLE RANKS..., which starts mpirun
# itself. folder: system (default) or stability, which is the test's label, too.
function(system_test name)
  cmake_parse_arguments(T "" "TIMEOUT;FOLDER" "RANKS" ${ARGN})
  if(NOT T_TIMEOUT)
    set(T_TIMEOUT 300)
  endif()
  if(NOT T_FOLDER)
    set(T_FOLDER system)
  endif()
  add_test(NAME ${name} COMMAND /usr/bin/python3 ${CMAKE_CURRENT_SOURCE_DIR}/${T_FOLDER}/${name}.py
                                $<TARGET_FILE:twogrid> ${T_RANKS})
  set(most 1)
  foreach(n ${T_RANKS})
    if(n GREATER most)
      set(most ${n})
    endif()
  endforeach()
  if(most GREATER 2)
    set(most 2)
  endif()
  set_tests_properties(${name} PROPERTIES TIMEOUT ${T_TIMEOUT} LABELS ${T_FOLDER} PROCESSORS ${most})
endfunction()

system_test(bad_input RANKS 1 TIMEOUT 400)
set_tests_properties(bad_input PROPERTIES RUN_SERIAL ON)  # it has a limit of 5 s a script
system_test(accuracy RANKS 1)
system_test(momentum RANKS 1 2)
system_test(action_reaction RANKS 2)
system_test(continuity RANKS 1 2)
system_test(ranks RANKS 2 4 8)
system_test(same_bits RANKS 1 2)
system_test(watched_drag RANKS 1 2)
system_test(mirror RANKS 1 2)
system_test(balance RANKS 2 4 8)
system_test(skin RANKS 1 2 4)
system_test(restart RANKS 1 2)
system_test(scripts RANKS 1 2)
system_test(one_particle RANKS 1)
system_test(fixed_bed RANKS 1)
system_test(fixed_particles RANKS 1)
system_test(bed_balance RANKS 2)
system_test(mueller_short RANKS 1 TIMEOUT 500)
system_test(methods RANKS 1)
system_test(min_fluidisation RANKS 1 TIMEOUT 400)
add_test(NAME batch_script COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/system/batch_script.sh)
set_tests_properties(batch_script PROPERTIES TIMEOUT 120 LABELS system)
system_test(settling RANKS 1)

# Hard cases: what is bounded and for how long stands in tests/stability/README.md.
system_test(fine_cells FOLDER stability RANKS 1)
system_test(fast_jet FOLDER stability RANKS 1)
system_test(stiff_drag FOLDER stability RANKS 1)
system_test(corners FOLDER stability RANKS 1 2 4)
system_test(outlets FOLDER stability RANKS 1)
system_test(periodic_settling FOLDER stability RANKS 1 2)
system_test(endurance FOLDER stability RANKS 1)
system_test(come_and_go FOLDER stability RANKS 1 2)
system_test(overfull FOLDER stability RANKS 1)
system_test(intervals FOLDER stability RANKS 1)
system_test(sweep RANKS 1)
# A few runs of every study against its table.
add_test(NAME studies_short COMMAND ${CMAKE_SOURCE_DIR}/cases/studies/run.sh --short -j 1)
set_tests_properties(studies_short PROPERTIES TIMEOUT 400 LABELS system ENVIRONMENT "TWOGRID=$<TARGET_FILE:twogrid>")
