# What every ctest entry is labelled with: one cost and one or more areas. Both come from where the test's file is, so that a
# test that is added or moved is labelled too; tests/tools/cli/test_labels.py checks it. docs/evidence/tests.md explains the labels.
#
# Costs, from cheap to dear:
#   quick    seconds; ./run test quick runs all of them in less than a minute
#   area     also run by ./run test AREA, which takes less than two minutes
#   whole    only run by ./run test, which runs quick and area too
#   nightly  sweeps, real captures, endurance, matrices: run by ./run test nightly, and by nothing else
# Entries "quick: NAME" and "area: NAME" are one process with the short cases of a Catch2 executable; the whole run leaves them out
# and runs every case as an entry of its own.

# ./run reads this line: it lists the areas of ./run test AREA.
set(FVV_TEST_AREAS core media render geometry scene mux demux compare tools js python conformance charts fuzz install docs style real)

# What tests in Python and JavaScript run.
set(FVV_TEST_TOOLS fvvcompare fvvdemux fvvimport fvvinfo fvvmux fvvrecover fvvrender fvvserve fvvsynth)

set(FVV_CORE_FOLDERS base container mesh calibration visibility video environment stream)

# Entries that are not of cost "area", by name: regular expressions. The first list with one that matches counts.
set(FVV_NIGHTLY_TESTS "real: .*" "cli: every_fault" "js: matrix" "cli: linear_time" "js: vite dev" "js: (player: )?chaos: .*" "js: firefox: .*" "js: player: (endurance|xr)"
  "js: video fallback: (hostile|browser)"
  "charts: (degradations|stability)" "conformance: damage" "install: Windows" "charts: quick" "python: write_properties"
  "python: (distributed|orders)" "python: capture (chain|pipeline|calibrate)"
  # The twin with sanitizers replays them in every run.
  "fuzz: seeds")
set(FVV_QUICK_TESTS "quick: .*" "cli: layers" "cli: labels" "cli: reference" "js: .* are current")
set(FVV_WHOLE_TESTS "cli: (faults|max_memory|nesting|style|sweep|footage|films|textured_meshes|parts|inputs|cases|fvvrecover|atlas|openexr|environment|cameras|chain|geometry|stability|film|fvvrender|progress|outputs|conformance_cases|serve_live)"
  "python: (cluster|threads|notebook|examples|capture .*)" "samples" "install: packages?.*" "fuzz: (mutations|amplification)"
  "conformance: (decoders|rendering|large_offsets)"
  "js: (packages|samples|browser|sound|site|live|ladder|settle|network|chaos|three(: .*)?)" "js: docs: (samples|pages)" "js: player: .*" "js: build the video fallback"
  "js: video fallback: .*")
# Under sanitizers all but these are nightly: they repeat arithmetic that others cover, at a third of the speed. These read bytes
# that anybody may have written, or run a tool on them.
set(FVV_SANITIZED_EXECUTABLES base container mesh colours delta fast stability calibration visibility video environment stream media capture
  import mux demux failure)
set(FVV_SANITIZED_TESTS "fuzz: .*" "cli: (fvvinfo|fvvrecover|cases|import|segments|sweep|conformance_cases|serve_http|serve_live|animations|hostile|nesting|masks)")

# fvv_areas(SOURCE OUT): the areas of a test by its path below the project's root.
function(fvv_areas source out)
  set(areas "")
  string(REPLACE ";" "|" core "${FVV_CORE_FOLDERS}")
  if(source MATCHES "^tests/(${core})/")
    list(APPEND areas core)
  elseif(source MATCHES "^js/docs/")
    list(APPEND areas js docs)
  elseif(source MATCHES "^js/|^tests/js/")
    list(APPEND areas js)
  elseif(source MATCHES "^bindings/python/")
    list(APPEND areas python)
  elseif(source MATCHES "/real/")
    list(APPEND areas real)
  elseif(source MATCHES "^tests/samples")
    list(APPEND areas docs)
  elseif(source MATCHES "^tests/tools/.*(style|layers|labels|spec)")
    list(APPEND areas style)
  elseif(source MATCHES "^tests/([a-z]+)/")
    list(APPEND areas ${CMAKE_MATCH_1})
  endif()
  # Tests of tools belong to the library that does the work, too.
  if(source MATCHES "^tests/tools/")
    foreach(pair "mux=/mux/|environment|atlas|chain|geometry|cameras|openexr" "demux=/demux/" "render=/render/|fvvrender" "compare=fvvcompare"
        "scene=import|cameras|openexr" "conformance=conformance|reference|/recover/" "media=openexr")
      string(REGEX MATCH "^([a-z]+)=(.*)$" unused "${pair}")
      set(area ${CMAKE_MATCH_1})
      if(source MATCHES "${CMAKE_MATCH_2}")
        list(APPEND areas ${area})
      endif()
    endforeach()
  endif()
  foreach(area ${areas})
    if(NOT area IN_LIST FVV_TEST_AREAS)
      message(FATAL_ERROR "${source}: a test of area ${area}, which FVV_TEST_AREAS in tests/labels.cmake does not list")
    endif()
  endforeach()
  if(NOT areas)
    message(FATAL_ERROR "${source}: no area; add a pattern to fvv_areas in tests/labels.cmake")
  endif()
  set(${out} ${areas} PARENT_SCOPE)
endfunction()

# fvv_matches(NAME LIST OUT): whether one of the list's regular expressions is that of the whole name.
function(fvv_matches name list out)
  set(${out} FALSE PARENT_SCOPE)
  foreach(pattern ${${list}})
    if(name MATCHES "^(${pattern})$")
      set(${out} TRUE PARENT_SCOPE)
    endif()
  endforeach()
endfunction()

# fvv_cost(NAME OUT): the cost of an entry.
function(fvv_cost name out)
  if(FVV_SANITIZE)
    fvv_matches(${name} FVV_SANITIZED_TESTS in_twin)
    if(in_twin OR name IN_LIST FVV_SANITIZED_EXECUTABLES)
      set(${out} whole PARENT_SCOPE)
    else()
      set(${out} nightly PARENT_SCOPE)
    endif()
    return()
  endif()
  fvv_matches(${name} FVV_NIGHTLY_TESTS nightly)
  fvv_matches(${name} FVV_QUICK_TESTS quick)
  fvv_matches(${name} FVV_WHOLE_TESTS whole)
  set(${out} area PARENT_SCOPE)
  foreach(cost whole quick nightly)
    if(${cost})
      set(${out} ${cost} PARENT_SCOPE)
    endif()
  endforeach()
endfunction()

# fvv_label(SOURCE NAME...): labels entries of the current folder whose file is SOURCE, a path below the project's root. Sets areas.
function(fvv_label source)
  fvv_areas(${source} areas)
  set(areas ${areas} PARENT_SCOPE)
  foreach(name ${ARGN})
    fvv_cost(${name} cost)
    set_tests_properties(${name} PROPERTIES LABELS "${areas};${cost}")
  endforeach()
endfunction()

# fvv_add_pytest(NAME FILE [TIMEOUT seconds] [ARGUMENTS word...] [ENVIRONMENT NAME=VALUE...]): a file of pytest, or a folder, as an entry.
function(fvv_add_pytest name file)
  cmake_parse_arguments(TEST "" "TIMEOUT" "ARGUMENTS;ENVIRONMENT" ${ARGN})
  # Importing hypothesis takes longer than most files do; those that use it need no plugin for that.
  add_test(NAME ${name} COMMAND ${FVV_PYTHON} -m pytest -q -p no:cacheprovider -p no:hypothesispytest ${TEST_ARGUMENTS} ${file}
    WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
  set_tests_properties(${name} PROPERTIES TIMEOUT ${TEST_TIMEOUT} ENVIRONMENT
    "PYTHONDONTWRITEBYTECODE=1;FVV_EIGHT_FRAMES=${CMAKE_BINARY_DIR}/eight_frames;${TEST_ENVIRONMENT}")
  if(NOT IS_DIRECTORY ${PROJECT_SOURCE_DIR}/${file})
    file(STRINGS ${PROJECT_SOURCE_DIR}/${file} uses REGEX "eight_frames" LIMIT_COUNT 1)
    if(uses)
      set_tests_properties(${name} PROPERTIES FIXTURES_REQUIRED eight_frames)
    endif()
  endif()
  fvv_label(${file} ${name})
  foreach(area ${areas})
    add_dependencies(tests_${area} ${FVV_TEST_TOOLS})
  endforeach()
endfunction()
