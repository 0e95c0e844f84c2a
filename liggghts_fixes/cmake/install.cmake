# cmake --install: bin/twogrid; in share/twogrid cases, scripts and pages as they lie in the source, so that links and paths between
# them hold. The scripts find the program by their own place (cases/program.sh): both folders are fixed.
install(TARGETS twogrid RUNTIME DESTINATION bin)
install(DIRECTORY cases DESTINATION share/twogrid USE_SOURCE_PERMISSIONS
        PATTERN out EXCLUDE PATTERN __pycache__ EXCLUDE PATTERN "*.log" EXCLUDE
        PATTERN setup.sh EXCLUDE PATTERN build.sh EXCLUDE)
install(DIRECTORY cfd coupling liggghts_fixes tests DESTINATION share/twogrid FILES_MATCHING PATTERN "*.md")
install(FILES README.md LICENCE DESTINATION share/twogrid)
# Reads dumps and tables for measure.py of cases/studies.
install(FILES tests/system/harness.py DESTINATION share/twogrid/tests/system)

# Libraries are found where they were when it was built, whatever modules are loaded.
set_target_properties(twogrid PROPERTIES INSTALL_RPATH_USE_LINK_PATH ON)

# The Python of the installed scripts: the first one that has what they import.
if(NOT TWOGRID_PYTHON)
  foreach(python "/usr/bin/env python3" "/usr/bin/python3")
    string(REPLACE " " ";" command "${python}")
    execute_process(COMMAND ${command} -c "import numpy, h5py, matplotlib" RESULT_VARIABLE failed OUTPUT_QUIET ERROR_QUIET)
    if(NOT failed)
      set(TWOGRID_PYTHON "${python}" CACHE STRING "Python of the installed scripts, as it stands after #!")
      break()
    endif()
  endforeach()
endif()
if(NOT TWOGRID_PYTHON)
  set(TWOGRID_PYTHON "/usr/bin/env python3")
  message(STATUS "python3 lacks numpy, h5py or matplotlib: runs need none of them; comparisons, pictures and reports do (load their module)")
endif()
install(CODE "set(python \"${TWOGRID_PYTHON}\")")
install(CODE [[
  file(GLOB_RECURSE scripts "$ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/share/twogrid/*")
  foreach(script ${scripts})
    file(READ "${script}" begin LIMIT 18)
    if(begin STREQUAL "#!/usr/bin/python3" AND NOT python STREQUAL "/usr/bin/python3")
      execute_process(COMMAND sed -i "1s,^.*$,#!${python}," "${script}")
    endif()
  endforeach()
]])
