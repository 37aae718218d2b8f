# Contact libraries to compare with, each where its package is installed: targets fcl, ccd,
# PkgConfig::QUOIN_BULLET, PkgConfig::QUOIN_ODE and PkgConfig::QUOIN_PETSC. The libraries of quoin never link them.
find_package(fcl QUIET)
find_package(ccd QUIET)
find_package(PkgConfig QUIET)
if(PkgConfig_FOUND)
  pkg_check_modules(QUOIN_BULLET QUIET IMPORTED_TARGET bullet-float64)
  pkg_check_modules(QUOIN_ODE QUIET IMPORTED_TARGET ode)
  pkg_check_modules(QUOIN_PETSC QUIET IMPORTED_TARGET PETSc)
  if(QUOIN_PETSC_FOUND)
    find_package(MPI QUIET COMPONENTS CXX)
  endif()
endif()
