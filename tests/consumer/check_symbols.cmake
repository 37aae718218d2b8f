# The dynamic symbols that a library defines are the functions that its header declares.
# cmake -DNM=… -DLIBRARY=… -DHEADER=… -P check_symbols.cmake
execute_process(COMMAND ${NM} -D --defined-only ${LIBRARY} OUTPUT_VARIABLE listing
  COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "[^ \n]+\n" shown "${listing}")
list(TRANSFORM shown STRIP)
list(SORT shown)
file(READ ${HEADER} header)
string(REGEX MATCHALL "quoin_[a-z_]+\\(" declared "${header}")
list(TRANSFORM declared REPLACE "\\(" "")
list(REMOVE_DUPLICATES declared)
list(SORT declared)
if(NOT shown STREQUAL declared)
  message(FATAL_ERROR "${LIBRARY} shows\n${shown}\nits header declares\n${declared}")
endif()
