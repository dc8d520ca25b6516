# Man pages from the pages in docs, completion from the program's own list of options: made by the
# build, installed with the program.

add_executable(orient_command_line tools/completion/main.cpp)
target_link_libraries(orient_command_line PRIVATE orient_tools)
orient_compile_options(orient_command_line)

set(manuals ${PROJECT_BINARY_DIR}/manuals)
file(GLOB pages CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/docs/*.md)
set(scripts ${PROJECT_SOURCE_DIR}/cmake)
add_custom_command(
  OUTPUT ${manuals}/made
  COMMAND Python3::Interpreter ${scripts}/man_pages.py $<TARGET_FILE:orient_command_line>
          ${PROJECT_SOURCE_DIR}/docs ${PROJECT_VERSION} ${manuals}/man1
  COMMAND Python3::Interpreter ${scripts}/completion.py $<TARGET_FILE:orient_command_line>
          ${manuals}/orient.bash ${manuals}/_orient
  COMMAND ${CMAKE_COMMAND} -E touch ${manuals}/made
  DEPENDS orient_command_line ${pages} ${scripts}/man_pages.py ${scripts}/completion.py
          ${scripts}/command_line.py
  VERBATIM)
add_custom_target(orient_manuals ALL DEPENDS ${manuals}/made)

set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME orient)
install(DIRECTORY ${manuals}/man1 DESTINATION ${CMAKE_INSTALL_MANDIR})
install(FILES ${manuals}/orient.bash RENAME orient
        DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
# Where zsh looks: Debian's packages have a folder of their own.
install(CODE "
  set(folder site-functions)
  if(CMAKE_INSTALL_PREFIX STREQUAL \"/usr\")
    set(folder vendor-completions)
  endif()
  file(INSTALL \"${manuals}/_orient\"
       DESTINATION \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_DATADIR}/zsh/\${folder}\")"
        COMPONENT orient)
install(DIRECTORY docs/ DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
