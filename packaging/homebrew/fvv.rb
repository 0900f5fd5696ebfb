class Fvv < Formula
  desc "Streaming file format for free-viewpoint video: library and tools"
  homepage "https://fvv.example"
  url "https://fvv.example/fvv.git", tag: "v0.2.0"
  license "Apache-2.0"
  head "https://fvv.example/fvv.git", branch: "main"

  depends_on "boost" => :build
  depends_on "cli11" => :build
  depends_on "cmake" => :build
  depends_on "ninja" => :build
  depends_on "nlohmann-json" => :build
  depends_on "pkgconf" => :build
  depends_on "draco"
  depends_on "expat"
  depends_on "ffmpeg"
  depends_on "jpeg-turbo"
  depends_on "libpng"
  depends_on "eigen"
  depends_on "meshoptimizer"
  depends_on "openexr"
  depends_on "tomlplusplus"
  depends_on "webp"
  depends_on "yaml-cpp"

  resource "stb" do
    url "https://github.com/nothings/stb.git", branch: "master"
  end

  def install
    (buildpath/"include/stb").install resource("stb")
    system "cmake", "-S", ".", "-B", "build", "-G", "Ninja", "-DFVV_TESTS=OFF",
                    "-DSTB_INCLUDE_DIR=#{buildpath}/include", *std_cmake_args
    system "cmake", "--build", "build"
    system "cmake", "--install", "build"
  end

  test do
    system bin/"fvvsynth", "-o", "capture", "--rig", "small", "--cameras", "3", "--frames", "2", "--size", "96x64"
    system bin/"fvvmux", "capture", "-o", "players.fvv"
    assert_match "2 frames", shell_output("#{bin}/fvvinfo --check players.fvv")
  end
end
