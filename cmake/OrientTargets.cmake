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

# What address and undefined-behaviour sanitizer look at. Null, misaligned and out-of-object accesses
# are the former's already; asking twice makes Eigen's templates compile half as long again.
set(ORIENT_SANITIZERS -fsanitize=address,undefined)
set(ORIENT_SANITIZED -O1 -g1 -UNDEBUG ${ORIENT_SANITIZERS} -fno-omit-frame-pointer
    -fno-sanitize=null,alignment,object-size,pointer-overflow -fno-sanitize-recover=undefined
    # Under a sanitizer Eigen would align memory by itself, and the tests' own code free it wrongly.
    -DEIGEN_MALLOC_ALREADY_ALIGNED=1)

function(orient_compile_options target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion
                         -Wno-sign-conversion -Werror)
endfunction()

# orient_sanitized_names(out ...): the same libraries, ours as their sanitized twins.
function(orient_sanitized_names out)
  list(TRANSFORM ARGN REPLACE "^(orient_.+)$" "\\1_sanitized")
  set(${out} ${ARGN} PARENT_SCOPE)
endfunction()

# orient_precompiled(name OPTIONS ... LINK ... HEADERS ...): headers compiled once, for all targets that
# REUSE_FROM it: those with the same options. It has no definitions of its own, else GCC would refuse.
function(orient_precompiled name)
  cmake_parse_arguments(PARSE_ARGV 1 its "" "" "OPTIONS;LINK;HEADERS")
  file(GENERATE OUTPUT ${CMAKE_BINARY_DIR}/${name}.cpp CONTENT "")
  add_library(${name} OBJECT EXCLUDE_FROM_ALL ${CMAKE_BINARY_DIR}/${name}.cpp)
  target_link_libraries(${name} PRIVATE ${its_LINK})
  orient_compile_options(${name})
  target_compile_options(${name} PRIVATE ${its_OPTIONS})
  target_precompile_headers(${name} PRIVATE ${its_HEADERS})
endfunction()

function(orient_one_library name)
  cmake_parse_arguments(PARSE_ARGV 1 one "" "TWIN" "SOURCES;LINK;OPTIONS")
  add_library(${name} STATIC ${one_SOURCES})
  target_include_directories(${name} PUBLIC ${CMAKE_SOURCE_DIR})
  target_link_libraries(${name} ${one_LINK})
  orient_compile_options(${name})
  target_compile_options(${name} PRIVATE ${one_OPTIONS})
  target_precompile_headers(${name} REUSE_FROM orient_precompiled${one_TWIN})
endfunction()

# orient_library(name folder PUBLIC ... PRIVATE ...): every .cpp of the folder and its subfolders,
# but for main.cpp and benchmarks, linked with what follows. Its twin <name>_sanitized is built when
# somebody asks for it (target `sanitized`): the tests' own code need not be compiled twice for it.
function(orient_library name folder)
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/${folder}/*.cpp)
  list(FILTER sources EXCLUDE REGEX "/main\\.cpp$|/bench/")
  orient_one_library(${name} SOURCES ${sources} LINK ${ARGN})
  orient_sanitized_names(twins ${ARGN})
  orient_one_library(${name}_sanitized TWIN _sanitized SOURCES ${sources} LINK ${twins}
                     OPTIONS ${ORIENT_SANITIZED})
  set_target_properties(${name}_sanitized PROPERTIES EXCLUDE_FROM_ALL ON)
endfunction()
