# No function of the files that are compiled for wide instructions may stand for one of the rest of the
# library: cmake -DNM=… -DOBJECTS=… -P check_kernels.cmake. A weak function is one of which the linker
# keeps any copy.
set(looked_at 0)
foreach(object ${OBJECTS})
  if(NOT object MATCHES "kernels/avx")
    continue()
  endif()
  math(EXPR looked_at "${looked_at} + 1")
  execute_process(COMMAND ${NM} --defined-only ${object} OUTPUT_VARIABLE symbols
    COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX MATCHALL "[^\n]* W [^\n]*" shared "${symbols}")
  if(shared)
    list(JOIN shared "\n" shared)
    message(FATAL_ERROR "${object} has functions that others may be given:\n${shared}")
  endif()
endforeach()
if(NOT looked_at EQUAL 1)
  message(FATAL_ERROR "looked at ${looked_at} files of kernels, not 1")
endif()
