# skein_library(NAME FILES... LINK LIBS...): a static library of one room, with the project's warnings and sanitizers.
add_library(skein_options INTERFACE)
target_include_directories(skein_options INTERFACE ${PROJECT_SOURCE_DIR} ${PROJECT_SOURCE_DIR}/src
                           ${PROJECT_SOURCE_DIR}/include ${PROJECT_BINARY_DIR}/include)
target_compile_options(skein_options INTERFACE -Wall -Wextra -Werror)
target_compile_definitions(skein_options INTERFACE SKEIN_ASSERT_LEVEL=${SKEIN_ASSERT_LEVEL})
if(CMAKE_BUILD_TYPE STREQUAL "Release")
  target_compile_options(skein_options INTERFACE -O3 -fno-math-errno -fno-trapping-math)
endif()
if(SKEIN_NATIVE)
  target_compile_options(skein_options INTERFACE -march=native)
endif()
if(SKEIN_SANITIZE)
  target_compile_definitions(skein_options INTERFACE SKEIN_SANITIZED)
  target_compile_options(skein_options INTERFACE -fsanitize=${SKEIN_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(skein_options INTERFACE -fsanitize=${SKEIN_SANITIZE})
endif()
target_link_libraries(skein_options INTERFACE fmt::fmt)

function(skein_library name)
  cmake_parse_arguments(ARG "" "" "FILES;LINK" ${ARGN})
  add_library(${name} STATIC ${ARG_FILES})
  target_link_libraries(${name} PUBLIC skein_options ${ARG_LINK})
endfunction()

# The rooms that the public headers need, which make up libskein.
set(skein_library_rooms base comm mesh metric geometry kernel partition dist solution adapt report statistics api)

# Of a shared library only what the public headers have; see skein.map.
function(skein_show_only_api target)
  set(map ${PROJECT_SOURCE_DIR}/cmake/skein.map)
  get_target_property(type ${target} TYPE)
  if(type STREQUAL "SHARED_LIBRARY")
    target_link_options(${target} PRIVATE LINKER:--version-script=${map})
    set_target_properties(${target} PROPERTIES LINK_DEPENDS ${map})
  endif()
endfunction()
