# Run by CTest before the tests: adds one test per suite of a GoogleTest executable, not one per
# TEST as gtest_discover_tests does. Starting the program takes 0.2 s, for the libraries of GDAL and
# OpenCV, and the set-up shared by a suite's tests runs only once.
# discover_suites(executable): suites named Slow... have the label `slow`.
function(discover_suites executable)
  if(NOT EXISTS ${executable})
    add_test(${executable}_NOT_BUILT ${executable})
    return()
  endif()
  execute_process(COMMAND ${executable} --gtest_list_tests OUTPUT_VARIABLE listed
                  COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX MATCHALL "[^\n]+" lines "${listed}")
  foreach(line IN LISTS lines)
    # Suites are not indented: "Suite.", "Instance/Suite." or "Suite/0.  # TypeParam = ...".
    if(NOT line MATCHES "^([A-Za-z][A-Za-z0-9_/]*)\\.( .*)?$")
      continue()
    endif()
    set(suite ${CMAKE_MATCH_1})
    add_test(${suite} ${executable} --gtest_brief=1 "--gtest_filter=${suite}.*")
    # RapidCheck draws a new seed in every run; a fixed one makes the tests repeatable. Keeping
    # released memory, as the program does (KeepReleasedMemory), saves a third of the time.
    set_tests_properties(${suite} PROPERTIES ENVIRONMENT
      "RC_PARAMS=seed=20250417;MALLOC_MMAP_THRESHOLD_=33554432;MALLOC_TRIM_THRESHOLD_=268435456")
    if(suite MATCHES "^(.*/)?Slow")
      set_tests_properties(${suite} PROPERTIES LABELS slow TIMEOUT 3600)
    endif()
  endforeach()
endfunction()
