# cpack -G DEB: four Debian packages of this build (packaging/README.md). Everything that is not marked otherwise is for those who
# build against libfvv.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME fvv)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_CONTACT "The fvv authors <packages@fvv.example>")
set(CPACK_PACKAGE_HOMEPAGE_URL https://fvv.example)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL library encoder dev tools)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
# The tools have no libfvv.so to look for: they contain the library.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/libfvv)

# The name changes with the SONAME, so that two can be installed beside each other (docs/project/abi.md).
set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME libfvv${FVV_SOVERSION})
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libs)
set(CPACK_COMPONENT_LIBRARY_DESCRIPTION "Streaming file format for free-viewpoint video: the shared library
 libfvv reads and writes fvv streams: meshes, pictures of many cameras, their
 calibration, visibility and sound.")

set(CPACK_DEBIAN_ENCODER_PACKAGE_NAME libfvv-encoder${FVV_SOVERSION})
set(CPACK_DEBIAN_ENCODER_PACKAGE_SECTION libs)
set(CPACK_COMPONENT_ENCODER_DESCRIPTION "Streaming file format for free-viewpoint video: an encoder in C
 libfvv_encoder makes fvv streams of meshes, pictures, masks and sound in
 memory.")

set(CPACK_DEBIAN_DEV_PACKAGE_NAME libfvv-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS
  "libfvv${FVV_SOVERSION} (= ${PROJECT_VERSION}), libfvv-encoder${FVV_SOVERSION} (= ${PROJECT_VERSION}), libdraco-dev, libmeshoptimizer-dev")
# What the C++ libraries beside libfvv need.
set(CPACK_DEBIAN_DEV_PACKAGE_RECOMMENDS
  "libavcodec-dev, libavformat-dev, libavutil-dev, libswscale-dev, libswresample-dev, libturbojpeg0-dev, libpng-dev, libwebp-dev, libopenexr-dev, libexpat1-dev, libyaml-cpp-dev, nlohmann-json3-dev")
set(CPACK_COMPONENT_DEV_DESCRIPTION "Streaming file format for free-viewpoint video: headers and static libraries
 The C library libfvv, and the C++ libraries that encode, decode and draw
 streams, with pkg-config files and a CMake package.")

set(CPACK_DEBIAN_TOOLS_PACKAGE_NAME fvv-tools)
set(CPACK_DEBIAN_TOOLS_PACKAGE_SECTION video)
set(CPACK_COMPONENT_TOOLS_DESCRIPTION "Streaming file format for free-viewpoint video: command-line tools
 fvvmux packs captures, fvvinfo inspects streams, fvvdemux unpacks, fvvrender
 draws, fvvserve serves, fvvrecover repairs, fvvimport reads calibrations,
 fvvcompare measures meshes and fvvsynth generates captures.")
# Licences: of fvv, and of what is in the binaries or beside them.
foreach(component library encoder dev tools)
  string(TOUPPER ${component} upper)
  install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${CPACK_DEBIAN_${upper}_PACKAGE_NAME} COMPONENT ${component})
  install(FILES ${PROJECT_SOURCE_DIR}/packaging/NOTICES DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${CPACK_DEBIAN_${upper}_PACKAGE_NAME}
    COMPONENT ${component} RENAME copyright)
endforeach()
include(CPack)
