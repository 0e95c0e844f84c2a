# TWOGRID_COMMIT, which every output file bears: git's, if this is a checkout; in an archive that git made, what git wrote below; else
# none. A folder above that happens to be a checkout of something else is not asked.
set(TWOGRID_COMMIT "")
if(EXISTS "${CMAKE_SOURCE_DIR}/.git")
  execute_process(COMMAND git -C "${CMAKE_SOURCE_DIR}" describe --always --dirty --abbrev=12
                  OUTPUT_VARIABLE TWOGRID_COMMIT OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
set(archived "$Format:%h$")
if(NOT TWOGRID_COMMIT AND archived MATCHES "^[0-9a-f]+$")
  set(TWOGRID_COMMIT "${archived}")
endif()
if(NOT TWOGRID_COMMIT)
  set(TWOGRID_COMMIT "no commit")
endif()
