# Lists the files of a wheel beside the Python modules; scikit-build-core reads this (pyproject.toml). Destinations are relative to
# the package's folder; SKBUILD_... are those of the environment.
# A wheel has no symbolic links: the library is one file.
set_property(TARGET slipdisk_shared PROPERTY VERSION)
set_property(TARGET slipdisk_shared PROPERTY SOVERSION)
install(TARGETS slipdisk_shared LIBRARY DESTINATION lib)
install(TARGETS slipdisk_program DESTINATION bin)
install(DIRECTORY include/slipdisk TYPE INCLUDE FILES_MATCHING PATTERN "*.h")
install(DIRECTORY inputs DESTINATION share/slipdisk)
install(PROGRAMS tools/packaging/slipdisk.py DESTINATION ${SKBUILD_SCRIPTS_DIR} RENAME slipdisk)
install(DIRECTORY ${sd_manual}/man/ DESTINATION ${SKBUILD_DATA_DIR}/share/man/man1)
install(FILES ${sd_manual}/slipdisk DESTINATION ${SKBUILD_DATA_DIR}/share/bash-completion/completions)
