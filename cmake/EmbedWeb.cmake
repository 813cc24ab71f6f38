# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
# The tablet page, built by npm into the build tree, gzipped and compiled in.

# nadir_embed_web(TARGET): links TARGET to nadir_web_assets, whose header nadir_web_assets.hpp lists the page's files.
function(nadir_embed_web target)
  if(NOT TARGET nadir_web_assets)
    nadir_web_assets_library()
  endif()
  target_link_libraries(${target} PRIVATE nadir_web_assets)
endfunction()

function(nadir_web_assets_library)
  set(dist ${PROJECT_BINARY_DIR}/web)
  if(NADIR_WEB)
    set(files index.html page.js unpacker.js page.css sw.js icon.svg manifest.webmanifest)
    nadir_build_web(${dist} ${files})
  else()
    set(files index.html)
    file(CONFIGURE OUTPUT ${dist}/index.html CONTENT
      "<!doctype html><title>nadir</title><p>This nadir was built without its page (NADIR_WEB=OFF).</p>\n")
  endif()

  set(incbins "")
  set(externs "")
  set(entries "")
  set(packed "")
  foreach(file ${files})
    string(MAKE_C_IDENTIFIER "nadir_web_${file}" symbol)
    list(APPEND packed ${dist}/${file}.gz)
    add_custom_command(OUTPUT ${dist}/${file}.gz DEPENDS ${dist}/${file}
      COMMAND gzip -9nkf ${dist}/${file} VERBATIM)
    nadir_content_type(${file} type)
    string(APPEND incbins
      ".global ${symbol}\n.global ${symbol}_end\n${symbol}:\n.incbin \"${dist}/${file}.gz\"\n${symbol}_end:\n")
    string(APPEND externs "extern const unsigned char ${symbol}[], ${symbol}_end[];\n")
    string(APPEND entries "    {\"/${file}\", \"${type}\", ${symbol}, ${symbol}_end},\n")
  endforeach()

  set(generated ${PROJECT_BINARY_DIR}/generated)
  foreach(source nadir_web_assets.S nadir_web_assets.cpp nadir_web_assets.hpp)
    configure_file(${PROJECT_SOURCE_DIR}/cmake/embed_web/${source}.in ${generated}/${source} @ONLY)
  endforeach()
  set_source_files_properties(${generated}/nadir_web_assets.S PROPERTIES OBJECT_DEPENDS "${packed}")
  add_library(nadir_web_assets STATIC ${generated}/nadir_web_assets.S ${generated}/nadir_web_assets.cpp)
  target_include_directories(nadir_web_assets PUBLIC ${generated})
  target_link_libraries(nadir_web_assets PRIVATE nadir_warnings)
endfunction()

# The page's files in dist, made anew when a source or the lock file changes. Its node_modules stay beside its sources,
# where npm and the editors look for them.
function(nadir_build_web dist)
  find_program(NADIR_NPM npm)
  if(NOT NADIR_NPM)
    message(FATAL_ERROR "npm not found: the page cannot be built. Install Debian's npm, or configure with -DNADIR_WEB=OFF.")
  endif()
  set(web ${PROJECT_SOURCE_DIR}/web)
  set(installed ${web}/node_modules/.package-lock.json)
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${web}/src/* ${web}/public/*)
  list(TRANSFORM ARGN PREPEND ${dist}/ OUTPUT_VARIABLE outputs)
  add_custom_command(OUTPUT ${installed} DEPENDS ${web}/package-lock.json
    COMMAND ${NADIR_NPM} ci --no-audit --no-fund --ignore-scripts --loglevel=error
    COMMAND ${CMAKE_COMMAND} -E touch ${installed}
    WORKING_DIRECTORY ${web} COMMENT "Installing the page's npm packages" VERBATIM)
  add_custom_command(OUTPUT ${outputs}
    DEPENDS ${installed} ${sources} ${web}/index.html ${web}/vite.config.ts ${web}/tsconfig.json
    COMMAND ${NADIR_NPM} run --silent build -- --outDir ${dist} --emptyOutDir --logLevel warn
    WORKING_DIRECTORY ${web} COMMENT "Building the page" VERBATIM)
endfunction()

function(nadir_content_type file result)
  set(html "text/html; charset=utf-8")
  set(js "text/javascript; charset=utf-8")
  set(css "text/css; charset=utf-8")
  set(svg "image/svg+xml")
  set(webmanifest "application/manifest+json")
  cmake_path(GET file EXTENSION LAST_ONLY extension)
  string(SUBSTRING ${extension} 1 -1 extension)
  set(${result} "${${extension}}" PARENT_SCOPE)
endfunction()
