# Read at project() by deb.sh: no folder of the machine that builds stands in assertions.
add_compile_options(-fmacro-prefix-map=${CMAKE_CURRENT_SOURCE_DIR}/=)
