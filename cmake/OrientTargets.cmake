# C++ standard, warnings, sanitizers and precompiled headers, set once for all targets.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

# ccache with precompiled headers needs these two settings (ccache manual, "Precompiled headers").
find_program(CCACHE ccache)
if(CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env
      CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime
      CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} ${CCACHE})
  if(NOT CMAKE_DISABLE_PRECOMPILE_HEADERS)
    add_compile_options(-fpch-preprocess)
  endif()
endif()

# The libraries become part of the Python module (python/), and a target that reuses a precompiled
# header must be compiled like it: so everything is position-independent. None of our functions is
# ever replaced at load time, so the compiler need not allow for it.
add_compile_options(-fPIC -fno-semantic-interposition)
# No garbage collection in GCC before it has used a gigabyte: saves a twentieth of the time.
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  add_compile_options("SHELL:--param ggc-min-heapsize=1000000")
endif()

# Checks of the address and undefined-behaviour sanitizers (preset `asan`). Null, misaligned and
# out-of-object accesses are caught by the former; checking twice makes compiling Eigen's templates
# half as long again. Under a sanitizer, Eigen would align memory itself, and not every caller would
# free it accordingly.
option(ORIENT_SANITIZE "Build with address and undefined-behaviour sanitizer" OFF)
if(ORIENT_SANITIZE)
  add_compile_options(-fsanitize=address,undefined -fno-omit-frame-pointer
                      -fno-sanitize=null,alignment,object-size,pointer-overflow
                      -fno-sanitize-recover=undefined)
  add_compile_definitions(EIGEN_MALLOC_ALREADY_ALIGNED=1)
  add_link_options(-fsanitize=address,undefined)
endif()

# For libFuzzer (preset `fuzz`), with checks that GCC's sanitizers do not have.
option(ORIENT_FUZZ "Build orient_fuzz; needs Clang" OFF)
if(ORIENT_FUZZ)
  add_compile_options(-fsanitize=fuzzer-no-link,float-cast-overflow
                      -fno-sanitize-recover=float-cast-overflow -D_GLIBCXX_ASSERTIONS)
endif()

# Sanitizers check the libraries that read, compute and store; their callers need not be compiled
# again.
set(ORIENT_OBJECTS_OF "" CACHE PATH
    "Another build of the same sources whose tests and commands are linked, not compiled again")

# orient_other_objects(target binary_folder sources_variable): replaces the sources by the objects
# that the other build has compiled from them for this target.
function(orient_other_objects target folder variable)
  set(sources ${${variable}})
  list(TRANSFORM sources REPLACE "^${CMAKE_CURRENT_SOURCE_DIR}/(.*)$"
       "${ORIENT_OBJECTS_OF}/${folder}CMakeFiles/${target}.dir/\\1.o")
  set_source_files_properties(${sources} PROPERTIES EXTERNAL_OBJECT TRUE GENERATED TRUE)
  set(${variable} ${sources} PARENT_SCOPE)
endfunction()

# Inline functions are both in the other build's objects and in this build's libraries, and the
# linker takes the first: so all libraries come before the objects.
function(orient_libraries_first target)
  get_property(libraries GLOBAL PROPERTY ORIENT_LIBRARIES)
  list(TRANSFORM libraries REPLACE "(.+)" "$<TARGET_FILE:\\1>" OUTPUT_VARIABLE files)
  target_link_options(${target} PRIVATE LINKER:--whole-archive ${files} LINKER:--no-whole-archive)
  target_link_libraries(${target} PRIVATE ${libraries})
endfunction()

# Warnings are errors if CMAKE_COMPILE_WARNING_AS_ERROR is set (preset `ci`).
function(orient_compile_options target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion
                         -Wno-sign-conversion)
endfunction()

# orient_precompiled(name LINK ... HEADERS ...): precompiles headers once, for all targets that
# REUSE_FROM it. It has no definitions of its own, which GCC would reject.
function(orient_precompiled name)
  cmake_parse_arguments(PARSE_ARGV 1 its "" "" "LINK;HEADERS")
  file(GENERATE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp CONTENT "")
  add_library(${name} OBJECT EXCLUDE_FROM_ALL ${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp)
  target_link_libraries(${name} PRIVATE ${its_LINK})
  orient_compile_options(${name})
  target_precompile_headers(${name} PRIVATE ${its_HEADERS})
endfunction()

# orient_library(orient_module folder PUBLIC ... PRIVATE ...): all .cpp files of the folder and its
# subfolders except main.cpp and benchmarks, linked with the libraries given; alias orient::module.
function(orient_library name folder)
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${folder}/*.cpp)
  list(FILTER sources EXCLUDE REGEX "/main\\.cpp$|/bench/")
  if(ORIENT_OBJECTS_OF)  # commands read options and print, the simulator reads no foreign files
    set(callers ${sources})
    list(FILTER callers INCLUDE REGEX "/tools/(commands|simulate)/")
    list(FILTER sources EXCLUDE REGEX "/tools/(commands|simulate)/")
    orient_other_objects(${name} "" callers)
    list(APPEND sources ${callers})
  endif()
  add_library(${name} STATIC ${sources})
  string(REPLACE "orient_" "" room ${name})
  add_library(orient::${room} ALIAS ${name})
  set_target_properties(${name} PROPERTIES EXPORT_NAME ${room})
  target_include_directories(${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
                                            $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/orient>)
  target_compile_features(${name} PUBLIC cxx_std_20)
  target_link_libraries(${name} ${ARGN})
  orient_compile_options(${name})
  target_precompile_headers(${name} REUSE_FROM orient_precompiled)
  set_property(GLOBAL APPEND PROPERTY ORIENT_LIBRARIES ${name})
endfunction()

# orient_benchmark(name libraries ...): tools/bench/<name>.cpp.
function(orient_benchmark name)
  add_executable(${name} EXCLUDE_FROM_ALL tools/bench/${name}.cpp)
  target_link_libraries(${name} PRIVATE ${ARGN})
  orient_compile_options(${name})
  if(NOT TARGET benchmarks)
    add_custom_target(benchmarks)
  endif()
  add_dependencies(benchmarks ${name})
endfunction()

# orient_embed(target folder function patterns ...): embeds matching files of the folder in the
# target as `std::span<const EmbeddedFile> function()`, so that the program remains one file that
# cannot lose them. The next build notices changed, added and removed files.
function(orient_embed target folder function)
  list(TRANSFORM ARGN PREPEND ${PROJECT_SOURCE_DIR}/${folder}/)
  file(GLOB files CONFIGURE_DEPENDS ${ARGN})
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${files})
  set(table "")
  foreach(path IN LISTS files)
    get_filename_component(name ${path} NAME)
    file(READ ${path} contents)
    string(APPEND table "    {\"${name}\", R\"embedded(${contents})embedded\"},\n")
  endforeach()
  file(GENERATE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/${function}.cpp CONTENT
"#include <span>
#include \"core/base/embedded_file.h\"
namespace orient {
std::span<const EmbeddedFile> ${function}() {
  static constexpr EmbeddedFile kFiles[] = {
${table}  };
  return kFiles;
}
}  // namespace orient
")
  target_sources(${target} PRIVATE ${CMAKE_CURRENT_BINARY_DIR}/${function}.cpp)
endfunction()
