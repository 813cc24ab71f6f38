# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0

if(NADIR_TESTS)
  add_custom_target(unit_tests)
endif()

# nadir_room(NAME SOURCES a.cpp... [LINK lib...] [PRIVATE lib...] [TESTS unit...] [TEST_LINK lib...])
# One static library nadir_NAME (alias nadir::NAME). LINK: what its public headers need; PRIVATE: what only its sources use.
# TESTS: unit means tests/NAME/unit_test.cpp, one CTest entry NAME.unit each; TEST_LINK: what only the tests use.
# The targets tests_NAME and unit_tests build a room's tests, or all rooms'.
function(nadir_room name)
  cmake_parse_arguments(PARSE_ARGV 1 ROOM "" "" "SOURCES;LINK;PRIVATE;TESTS;TEST_LINK")
  add_library(nadir_${name} STATIC ${ROOM_SOURCES})
  add_library(nadir::${name} ALIAS nadir_${name})
  target_include_directories(nadir_${name} PUBLIC ${PROJECT_SOURCE_DIR}/include PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
  target_link_libraries(nadir_${name} PUBLIC ${ROOM_LINK} PRIVATE ${ROOM_PRIVATE} nadir_warnings)
  if(NADIR_TESTS)
    add_custom_target(tests_${name})
    add_dependencies(unit_tests tests_${name})
    foreach(unit ${ROOM_TESTS})
      nadir_test(${name}.${unit} ${PROJECT_SOURCE_DIR}/tests/${name}/${unit}_test.cpp
        LINK nadir::${name} ${ROOM_PRIVATE} ${ROOM_TEST_LINK} INCLUDE ${CMAKE_CURRENT_SOURCE_DIR})
      add_dependencies(tests_${name} test_${name}_${unit})
      set_tests_properties(${name}.${unit} PROPERTIES LABELS unit)
    endforeach()
  endif()
endfunction()

# nadir_test(NAME SOURCE [LINK lib...] [INCLUDE dir...]): a GoogleTest program and its CTest entry, run in the build's root.
function(nadir_test name source)
  cmake_parse_arguments(PARSE_ARGV 2 TEST "" "" "LINK;INCLUDE")
  string(REPLACE "." "_" target test_${name})
  add_executable(${target} ${source})
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR}/tests ${TEST_INCLUDE})
  target_link_libraries(${target} PRIVATE ${TEST_LINK} nadir_warnings GTest::gmock GTest::gtest_main)
  target_compile_definitions(${target} PRIVATE
    NADIR_SOURCE_DIR="${PROJECT_SOURCE_DIR}" NADIR_SHARED_DATA="${PROJECT_SOURCE_DIR}/../shared/data")
  add_test(NAME ${name} COMMAND ${target} WORKING_DIRECTORY ${CMAKE_BINARY_DIR})
endfunction()
