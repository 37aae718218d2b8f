# Builds a plug-in of the referee from the installed kit alone, and has it judged by the installed
# command. cmake -DBUILD=… -DWORK=… -DC=compiler -P plugin.cmake
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})
function(run)
  execute_process(COMMAND ${ARGV} WORKING_DIRECTORY ${WORK} COMMAND_ERROR_IS_FATAL ANY)
endfunction()
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)
run(${C} -shared -fPIC -O2 -Wall -Wextra -Werror -o gilbert.so
  ${CMAKE_CURRENT_LIST_DIR}/project/plugin.c -I ${WORK}/prefix/include -lm)
run(${WORK}/prefix/bin/quoin referee --plugin ./gilbert.so --family "^boxes$|^hulls$" --count 100
  --json report.json)
file(READ ${WORK}/report.json report)
string(JSON name GET "${report}" libraries 0 name)
string(JSON asked GET "${report}" libraries 0 families all asked)
string(JSON faulty GET "${report}" libraries 0 families all faulty)
message("${name}: ${asked} asked, ${faulty} faulty")
if(NOT name STREQUAL "Gilbert" OR asked LESS 30 OR NOT faulty EQUAL 0)
  message(FATAL_ERROR "the plug-in was not judged as it should be")
endif()
# What is installed is found without being named.
run(${WORK}/prefix/bin/quoin referee --family "^boxes$" --count 5 --json own.json)
file(READ ${WORK}/own.json report)
if(NOT report MATCHES "\"quoin C\"" OR NOT report MATCHES "\"name\": *\"quoin\"")
  message(FATAL_ERROR "the installed plug-ins were not found")
endif()
