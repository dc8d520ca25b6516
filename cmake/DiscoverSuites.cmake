# Run by CTest before the tests: one test a suite of an executable made with GoogleTest, not one a
# TEST as gtest_discover_tests has it. A start of the program takes 0.2 s, for the libraries of GDAL
# and OpenCV, and what a suite sets up for all of its tests is set up once.
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
    # Suites stand at the margin: "Suite.", "Instance/Suite." or "Suite/0.  # TypeParam = ...".
    if(NOT line MATCHES "^([A-Za-z][A-Za-z0-9_/]*)\\.( .*)?$")
      continue()
    endif()
    set(suite ${CMAKE_MATCH_1})
    add_test(${suite} ${executable} --gtest_brief=1 "--gtest_filter=${suite}.*")
    # RapidCheck draws a new seed every run; a test that others rely on repeats itself. Released
    # memory stays with the test, as with the program (KeepReleasedMemory): a third of the time.
    set_tests_properties(${suite} PROPERTIES ENVIRONMENT
      "RC_PARAMS=seed=20250417;MALLOC_MMAP_THRESHOLD_=33554432;MALLOC_TRIM_THRESHOLD_=268435456")
    if(suite MATCHES "^(.*/)?Slow")
      set_tests_properties(${suite} PROPERTIES LABELS slow TIMEOUT 3600)
    endif()
  endforeach()
endfunction()
