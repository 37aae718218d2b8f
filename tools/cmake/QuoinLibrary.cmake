# How each library of quoin is declared, exported and found again.

# quoin_library(<component> SOURCES … HEADERS … [PUBLIC …] [PRIVATE …])
# Makes quoin_<component>, alias quoin::<component>, from the calling folder: sources relative to it,
# public headers relative to its include/. PUBLIC and PRIVATE are what it links. Each component is an
# export set of its own, so that a consumer of one needs the packages of that one alone.
function(quoin_library component)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;HEADERS;PUBLIC;PRIVATE")
  set(target quoin_${component})
  list(TRANSFORM arg_HEADERS PREPEND include/)
  add_library(${target} ${arg_SOURCES})
  add_library(quoin::${component} ALIAS ${target})
  target_sources(${target} PUBLIC FILE_SET HEADERS BASE_DIRS include FILES ${arg_HEADERS})
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_link_libraries(${target} PUBLIC ${arg_PUBLIC}
    PRIVATE $<BUILD_INTERFACE:quoin_flags> ${arg_PRIVATE})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${component}
    UNITY_BUILD ${QUOIN_UNITY_BUILD} UNITY_BUILD_BATCH_SIZE 12
    VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
  if(QUOIN_BUILD_PYTHON AND NOT BUILD_SHARED_LIBS)  # the module takes it in
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON
      CXX_VISIBILITY_PRESET hidden)
  endif()
  install(TARGETS ${target} EXPORT quoin_${component} FILE_SET HEADERS)
  install(EXPORT quoin_${component} NAMESPACE quoin:: FILE quoin_${component}.cmake
    DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/quoin)
  quoin_pkg_config(${component} ${arg_PUBLIC} ${arg_PRIVATE})
endfunction()

# quoin_pkg_config(<component> <what it links>…): quoin-<component>.pc, if all of that has pkg-config files. What
# is private, too, is required: the libraries are static by default.
function(quoin_pkg_config component)
  set(target quoin_${component})
  string(REPLACE _ - name ${target})
  foreach(linked ${ARGN})
    if(linked STREQUAL Threads::Threads)
      set(threads -pthread)
    elseif(linked STREQUAL Eigen3::Eigen)
      list(APPEND requires eigen3)
    elseif(linked MATCHES "^quoin::(.*)")
      string(REPLACE _ - own quoin-${CMAKE_MATCH_1})
      list(APPEND requires ${own})
    elseif(linked MATCHES "^(fcl|ccd)$")
      string(APPEND libs " -l${linked}")  # not required: Debian's fcl.pc asks for -std=c++11
    else()
      return()
    endif()
  endforeach()
  list(JOIN requires ", " requires)
  file(RELATIVE_PATH to_prefix /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
  configure_file(${PROJECT_SOURCE_DIR}/tools/cmake/quoin.pc.in ${PROJECT_BINARY_DIR}/package/${name}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/package/${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endfunction()

# quoin_precompile(<target> <header>…): what most sources of a large target include is compiled once. Not
# where a compiler cache is, which does not know precompiled headers; nor where warnings are errors: gcc 12
# has false ones within std::string that come and go with what it inlines (its bug 105651).
function(quoin_precompile target)
  if(NOT CMAKE_CXX_COMPILER_LAUNCHER AND NOT QUOIN_WARNINGS_AS_ERRORS)
    target_precompile_headers(${target} PRIVATE ${ARGN})
  endif()
endfunction()

# The CMake package: find_package(quoin COMPONENTS narrow_phase geometry solver).
function(quoin_install_package)
  include(CMakePackageConfigHelpers)
  set(package ${PROJECT_BINARY_DIR}/package)
  set(destination ${CMAKE_INSTALL_LIBDIR}/cmake/quoin)
  configure_package_config_file(${PROJECT_SOURCE_DIR}/tools/cmake/quoinConfig.cmake.in
    ${package}/quoinConfig.cmake INSTALL_DESTINATION ${destination})
  write_basic_package_version_file(${package}/quoinConfigVersion.cmake
    COMPATIBILITY SameMinorVersion)
  install(FILES ${package}/quoinConfig.cmake ${package}/quoinConfigVersion.cmake
    DESTINATION ${destination})
endfunction()
