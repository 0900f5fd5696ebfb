vcpkg_from_git(
  OUT_SOURCE_PATH SOURCE_PATH
  URL https://fvv.example/fvv.git
  REF v${VERSION}
)
vcpkg_check_features(OUT_FEATURE_OPTIONS FEATURES
  FEATURES
    tools FVV_TOOLS
    tools FVV_MEDIA
)
vcpkg_find_acquire_program(PKGCONFIG)
vcpkg_cmake_configure(
  SOURCE_PATH "${SOURCE_PATH}"
  OPTIONS ${FEATURE_OPTIONS} -DFVV_TESTS=OFF "-DPKG_CONFIG_EXECUTABLE=${PKGCONFIG}"
)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH lib/cmake/fvv)
vcpkg_fixup_pkgconfig()
if("tools" IN_LIST FEATURES)
  vcpkg_copy_tools(TOOL_NAMES fvvcompare fvvdemux fvvimport fvvinfo fvvmux fvvrecover fvvrender fvvserve fvvsynth AUTO_CLEAN)
endif()
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include" "${CURRENT_PACKAGES_DIR}/debug/share")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
