# What tests need beside the build itself. A row: kind and name of what is looked for, Debian package, option of tools/install_deps.sh,
# pattern of the tests. Kinds: found (a variable of CMake), module (of Python), command, file. tests/docs/test_needs.py compares the
# rows with the tests.
set(sd_needs
  "found CMOCKA_FOUND libcmocka-dev --tests .*[.]c|test_crossing[.]py"
  "found RANDOM123_INCLUDE_DIR librandom123-dev --tests test_kernels[.]c"
  "found MICROHTTPD_FOUND libmicrohttpd-dev -- test_view_live[.]py"
  "found SLIPDISK_PYTHON python3-h5py --tests .*[.]py"
  "module matplotlib python3-matplotlib --tests test_(cell_readers|cookbook|falsified|kept|packings_.*|plot.*|private|python_measure|report|rheology|site|tutorial_notebook|typing|verdicts)[.]py"
  "module pandas python3-pandas --tests test_((tutorial_)?notebook|typing)[.]py"
  "module xarray python3-xarray --tests test_(notebook|typing)[.]py"
  "module tqdm python3-tqdm --tests test_notebook[.]py"
  "module IPython python3-ipykernel --tests test_notebook[.]py"
  "module ipykernel python3-ipykernel --tests test_tutorial_notebook[.]py"
  "module nbconvert python3-nbconvert --tests test_tutorial_notebook[.]py"
  "module mypy mypy --tests test_typing[.]py"
  "module MDAnalysis python3-mdanalysis --tests test_export_readers[.]py"
  "module ase python3-ase --tests test_export_readers[.]py"
  "module vtk python3-vtk9 --tests test_export_readers[.]py"
  "command lmp lammps --tests test_(export_readers|peers|peers_laws)[.]py"
  "module selenium python3-selenium --tests test_(play|play_pages|site|tutorial_notebook|viewer)[.]py"
  "command chromium chromium --tests test_(play|play_pages|site|tutorial_notebook|viewer)[.]py"
  "command chromedriver chromium-driver --tests test_(play|play_pages|site|tutorial_notebook|viewer)[.]py"
  "module PIL python3-pil --tests test_viewer[.]py"
  "module sphinx python3-sphinx --tests test_site[.]py"
  "module myst_parser python3-myst-parser --tests test_site[.]py"
  "module breathe python3-breathe --tests test_site[.]py"
  "module furo furo --tests test_site[.]py"
  "module sphinx_copybutton python3-sphinx-copybutton --tests test_site[.]py"
  "command doxygen doxygen --tests test_site[.]py"
  "file /usr/share/javascript/katex/katex.min.js libjs-katex --tests test_site[.]py"
  "file /usr/share/javascript/normalize.css/normalize.css node-normalize.css --tests test_site[.]py"
  "module jinja2 python3-jinja2 --tests test_version[.]py"
  "module yaml python3-yaml --tests test_version[.]py"
  "command ffmpeg ffmpeg --tests test_(plot_film|private|typing)[.]py"
  "command ffprobe ffmpeg --tests test_plot_film[.]py"
  "command xxhsum xxhash --tests test_checksums[.]py"
  "command parallel parallel --tests test_cluster[.]py"
  "command mandoc mandoc --tests test_manual[.]py"
  "command script bsdutils --tests test_manual[.]py"
  "command nm binutils --tests test_(circles|same_bits)[.]py"
  "command node nodejs --play test_play[.]py"
  "file build/play/packing.html emscripten --play test_play(_pages)?[.]py")

# One question for all of Python's modules, and for commands and files, as the tests will find them.
set(sd_asked)
foreach(row ${sd_needs})
  string(REPLACE " " ";" row "${row}")
  list(GET row 0 kind)
  list(GET row 1 name)
  if(kind STREQUAL "found")
    set(sd_has_${name} ${${name}})
  else()
    list(APPEND sd_asked ${kind} ${name})
  endif()
endforeach()
execute_process(COMMAND ${SLIPDISK_PYTHON} -c [[
import importlib.util, os, shutil, sys
there = {"module": importlib.util.find_spec, "command": shutil.which, "file": os.path.exists}
words = sys.argv[1:]
print(";".join(name for kind, name in zip(words[::2], words[1::2]) if there[kind](name)))]] ${sd_asked}
  WORKING_DIRECTORY ${PROJECT_SOURCE_DIR} OUTPUT_VARIABLE sd_there OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
foreach(name ${sd_there})
  set(sd_has_${name} ON)
endforeach()

# Is something missing that this test needs? Then it is told at the end of the configuration, by sd_left_out.
function(sd_left_out_test file result)
  set(${result} OFF PARENT_SCOPE)
  foreach(row ${sd_needs})
    string(REPLACE " " ";" row "${row}")
    list(GET row 1 name)
    list(GET row 2 package)
    list(GET row 3 option)
    list(GET row 4 pattern)
    if(file MATCHES "^(${pattern})$" AND NOT sd_has_${name})
      string(REGEX REPLACE "[.].*" "" test "${file}")
      sd_left_out(${test} ${package} ${option})
      set(${result} ON PARENT_SCOPE)
    endif()
  endforeach()
endfunction()
