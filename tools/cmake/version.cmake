# Writes OUTPUT from INPUT when the git revision of SOURCE (or anything else in it) has changed.
set(SD_GIT_REVISION unknown)
find_program(git git)
if(git)
  execute_process(COMMAND ${git} rev-parse --show-toplevel WORKING_DIRECTORY ${SOURCE}
                  OUTPUT_VARIABLE top OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  file(REAL_PATH ${SOURCE} source)
  # A tarball unpacked inside some other repository has no revision of its own.
  if(top STREQUAL source)
    execute_process(COMMAND ${git} rev-parse --verify HEAD WORKING_DIRECTORY ${SOURCE}
                    OUTPUT_VARIABLE revision OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
    if(NOT failed)
      execute_process(COMMAND ${git} status --porcelain --untracked-files=no WORKING_DIRECTORY ${SOURCE}
                      OUTPUT_VARIABLE changed ERROR_QUIET)
      set(SD_GIT_REVISION ${revision})
      if(changed)
        string(APPEND SD_GIT_REVISION "+")
      endif()
    endif()
  endif()
endif()
configure_file(${INPUT} ${OUTPUT} @ONLY)
