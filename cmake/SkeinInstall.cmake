# What cmake --install gives: headers, library, program, the CMake package and the pkg-config file.
include(CMakePackageConfigHelpers)

install(FILES include/skein/skein.hpp include/skein/skein.h include/skein/error.hpp include/skein/export.h
              ${PROJECT_BINARY_DIR}/include/skein/version.h
        DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/skein)
install(TARGETS libskein EXPORT SkeinTargets ARCHIVE LIBRARY RUNTIME)

# the CMake package
set(skein_package ${CMAKE_INSTALL_LIBDIR}/cmake/Skein)
if(BUILD_SHARED_LIBS)
  set(BUILD_SHARED_LIBS ON)
else()
  set(BUILD_SHARED_LIBS OFF)
endif()
install(EXPORT SkeinTargets NAMESPACE Skein:: DESTINATION ${skein_package})
configure_package_config_file(cmake/SkeinConfig.cmake.in ${PROJECT_BINARY_DIR}/SkeinConfig.cmake
                              INSTALL_DESTINATION ${skein_package})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/SkeinConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/SkeinConfig.cmake ${PROJECT_BINARY_DIR}/SkeinConfigVersion.cmake
        DESTINATION ${skein_package})

# pkg-config: of MPI the paths that CMake has found, since its names differ from one MPI to the other
foreach(name LIBDIR INCLUDEDIR)
  set(SKEIN_PC_${name} "\${prefix}/${CMAKE_INSTALL_${name}}")
  if(IS_ABSOLUTE "${CMAKE_INSTALL_${name}}")
    set(SKEIN_PC_${name} "${CMAKE_INSTALL_${name}}")
  endif()
endforeach()
list(TRANSFORM MPI_CXX_INCLUDE_DIRS PREPEND "-I" OUTPUT_VARIABLE SKEIN_PC_MPI_CFLAGS)
list(JOIN SKEIN_PC_MPI_CFLAGS " " SKEIN_PC_MPI_CFLAGS)
list(JOIN MPI_CXX_LIBRARIES " " SKEIN_PC_MPI_LIBS)
set(SKEIN_PC_REQUIRES_PRIVATE fmt)
set(SKEIN_PC_LIBS_PRIVATE "${OpenMP_CXX_FLAGS} -lgmp -lpthread -lstdc++ -lm")
if(BUILD_SHARED_LIBS) # they are in the shared library's own list
  set(SKEIN_PC_REQUIRES_PRIVATE "")
  set(SKEIN_PC_LIBS_PRIVATE "")
endif()
# The prefix may be chosen as late as by cmake --install --prefix.
install(CODE "set(SKEIN_PC_IN \"${PROJECT_SOURCE_DIR}/cmake/skein.pc.in\")")
foreach(name PROJECT_DESCRIPTION PROJECT_VERSION SKEIN_PC_REQUIRES_PRIVATE SKEIN_PC_MPI_CFLAGS SKEIN_PC_MPI_LIBS
             SKEIN_PC_LIBS_PRIVATE)
  install(CODE "set(${name} [==[${${name}}]==])")
endforeach()
install(CODE "set(SKEIN_PC_LIBDIR [==[${SKEIN_PC_LIBDIR}]==])\nset(SKEIN_PC_INCLUDEDIR [==[${SKEIN_PC_INCLUDEDIR}]==])")
install(CODE "configure_file(\${SKEIN_PC_IN} \"${PROJECT_BINARY_DIR}/skein.pc\" @ONLY)")
install(FILES ${PROJECT_BINARY_DIR}/skein.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
