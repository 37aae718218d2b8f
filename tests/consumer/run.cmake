# Builds and runs a foreign project against quoin: installed, or from its source.
# cmake -DBUILD=… -DWORK=… -DCOMPONENT=… -DPROGRAM=… -DOUTPUT=regex [-DWITHOUT=packages]
#   [-DINSTALLED=files] [-DSOURCE=folder or archive] [-DFETCH=ON] [-DLAUNCHER=…] -P run.cmake
function(run)
  execute_process(COMMAND ${ARGV} WORKING_DIRECTORY ${WORK} RESULT_VARIABLE result
    OUTPUT_VARIABLE output ERROR_VARIABLE output)
  message("${output}")
  if(NOT result EQUAL 0)
    list(JOIN ARGV " " command)
    message(FATAL_ERROR "failed: ${command}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})
set(options)
foreach(package ${WITHOUT})
  list(APPEND options -DCMAKE_DISABLE_FIND_PACKAGE_${package}=ON)
endforeach()
if(FETCH)  # an archive by its address, as from afar
  set(archive ${WORK}/quoin.tar.gz)
  execute_process(COMMAND ${CMAKE_COMMAND} -E tar cz ${archive} CMakeLists.txt geometry tools/cmake
    WORKING_DIRECTORY ${SOURCE} COMMAND_ERROR_IS_FATAL ANY)
  list(APPEND options -DQUOIN_SOURCE=file://${archive} -DQUOIN_FETCH=ON)
elseif(SOURCE)
  list(APPEND options -DQUOIN_SOURCE=${SOURCE})
else()
  run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)
  list(APPEND options -DCMAKE_PREFIX_PATH=${WORK}/prefix -DCMAKE_BUILD_TYPE=Release)
endif()
if(SOURCE)  # not optimised, several files at once: it is soon built, and a user may ask for either
  list(APPEND options -DQUOIN_BUILD_GEOMETRY=OFF -DCMAKE_BUILD_TYPE=None -DCMAKE_UNITY_BUILD=ON -DQUOIN_UNITY_BUILD=ON
    -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER})
endif()
run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR}/project -B ${WORK}/build
  -DCOMPONENT=${COMPONENT} -DPROGRAM=${PROGRAM} ${options})
if(FETCH)  # what is built is what add_subdirectory builds
  return()
endif()
run(${CMAKE_COMMAND} --build ${WORK}/build --target program --parallel 2)
run(${WORK}/build/program)
if(NOT output MATCHES "${OUTPUT}")
  message(FATAL_ERROR "the program did not say \"${OUTPUT}\"")
endif()
foreach(file ${INSTALLED})
  if(NOT EXISTS ${WORK}/prefix/${file})
    message(FATAL_ERROR "not installed: ${file}")
  endif()
endforeach()
