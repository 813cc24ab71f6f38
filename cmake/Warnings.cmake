# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
# The warnings of our own code; system packages are SYSTEM and stay silent.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()

add_library(nadir_warnings INTERFACE)
target_compile_options(nadir_warnings INTERFACE
  $<$<COMPILE_LANGUAGE:CXX>:-Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror>)

if(NADIR_SANITIZE)
  add_compile_options(-fsanitize=${NADIR_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  if(NADIR_SANITIZE MATCHES undefined)
    # A third of the time to compile; what they find, the address sanitizer finds when it happens.
    add_compile_options(-fno-sanitize=null,object-size,vptr)
  endif()
  add_link_options(-fsanitize=${NADIR_SANITIZE})
endif()
