# Standard, warnings, sanitizers and precompiled headers: set once, the same for every target.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

# ccache with precompiled headers needs these two settings (ccache manual, "Precompiled headers").
find_program(CCACHE ccache)
if(CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env
      CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime
      CCACHE_BASEDIR=${CMAKE_SOURCE_DIR} ${CCACHE})
  if(NOT CMAKE_DISABLE_PRECOMPILE_HEADERS)
    add_compile_options(-fpch-preprocess)
  endif()
endif()

option(ORIENT_SANITIZE "AddressSanitizer and UndefinedBehaviorSanitizer" OFF)

function(orient_compile_options target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion
                         -Wno-sign-conversion -Werror)
  if(ORIENT_SANITIZE)
    # Null, misaligned and out-of-object accesses are AddressSanitizer's already; asking twice makes
    # Eigen's templates compile half as long again.
    target_compile_options(${target} PRIVATE -fsanitize=address,undefined
                           -fno-sanitize=null,alignment,object-size,pointer-overflow
                           -fno-omit-frame-pointer -fno-sanitize-recover=undefined)
    target_link_options(${target} PRIVATE -fsanitize=address,undefined)
  endif()
endfunction()

# orient_library(name folder PUBLIC ... PRIVATE ...): every .cpp of the folder and its subfolders,
# but for main.cpp and benchmarks, linked with what follows.
function(orient_library name folder)
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/${folder}/*.cpp)
  list(FILTER sources EXCLUDE REGEX "/main\\.cpp$|/bench/")
  add_library(${name} STATIC ${sources})
  target_include_directories(${name} PUBLIC ${CMAKE_SOURCE_DIR})
  target_link_libraries(${name} ${ARGN})
  target_precompile_headers(${name} PRIVATE <algorithm> <array> <cmath> <functional> <map> <memory>
                            <optional> <string> <variant> <vector> <Eigen/Dense>)
  orient_compile_options(${name})
endfunction()
