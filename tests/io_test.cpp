// Clouds from and to files. Every file that a test reads is written by it: by our writer, by PCL-independent text and
// bytes here, or by damaging one of those.
#include "handhold/io.h"

#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <thread>

namespace handhold {
namespace {

namespace fs = std::filesystem;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

std::string contents(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

template <class T>
std::string raw(T value, bool swap = false) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  return swap ? std::string(bytes.rbegin(), bytes.rend()) : bytes;
}

class Io : public ::testing::Test {
 protected:
  void SetUp() override {
    const ::testing::TestInfo* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(::testing::TempDir()) / ("handhold_io_" + std::string(info->name()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::string file(const std::string& name, const std::string& bytes) const {
    std::ofstream(path(name), std::ios::binary) << bytes;
    return path(name);
  }

  // The error is one line that names the file and contains `part`.
  static void expect_error(const std::function<void()>& action, const std::string& file, const std::string& part) {
    try {
      action();
      ADD_FAILURE() << "no error; expected one with: " << part;
    } catch (const IoError& error) {
      const std::string what = error.what();
      EXPECT_NE(what.find(part), std::string::npos) << what;
      EXPECT_NE(what.find(file), std::string::npos) << what;
      EXPECT_EQ(what.find('\n'), std::string::npos) << what;
    }
  }
  static void expect_unreadable(const std::string& file, const std::string& part) {
    expect_error([&] { read_cloud(file); }, file, part);
  }

  fs::path folder_;
};

const std::vector<float> kPoints = {0.1f, -0.2f, 0.7f, kNan, kNan, kNan, 1e-7f, 2.5f, -3.0f,
                                    4,    5,     6,    7,    8,    9,    -1,    -2,   -3};

Cloud organized_cloud() {
  Cloud cloud;
  cloud.width = 3;
  cloud.height = 2;
  cloud.xyz = kPoints;
  cloud.viewpoint = Vector3{0.25, -0.5, 1.125};
  return cloud;
}

// Bit for bit, with every NaN alike.
void expect_same_points(const std::vector<float>& a, const std::vector<float>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::isnan(b[i])) {
      EXPECT_TRUE(std::isnan(a[i])) << i;
    } else {
      EXPECT_EQ(a[i], b[i]) << i;
    }
  }
}

std::string pcd_header(const std::string& fields, const std::string& size, const std::string& type,
                       const std::string& count, int width, int height, const std::string& data) {
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS " + fields + "\nSIZE " + size + "\nTYPE " +
         type + "\nCOUNT " + count + "\nWIDTH " + std::to_string(width) + "\nHEIGHT " + std::to_string(height) +
         "\nVIEWPOINT 0.5 0 -1 0 1 0 0\nPOINTS " + std::to_string(width * height) + "\nDATA " + data + "\n";
}
std::string xyz_header(int width, int height, const std::string& data) {
  return pcd_header("x y z", "4 4 4", "F F F", "1 1 1", width, height, data);
}

std::string ply_header(const std::string& format, int vertices, const std::string& properties) {
  return "ply\nformat " + format + " 1.0\ncomment made by a test\nelement vertex " + std::to_string(vertices) + "\n" +
         properties + "end_header\n";
}
const std::string kFloatXyz = "property float x\nproperty float y\nproperty float z\n";

TEST_F(Io, PcdComesBackAsItWasWritten) {
  const Cloud cloud = organized_cloud();
  for (const std::vector<std::uint32_t>& rgb :
       {std::vector<std::uint32_t>{},
        std::vector<std::uint32_t>{0xff0000, 0x00ff00, 0x0000ff, 0, 0xffffff, 0x123456}}) {
    write_pcd(path("cloud.pcd"), cloud.view(), rgb);
    const Cloud back = read_cloud(path("cloud.pcd"));
    EXPECT_EQ(back.width, 3u);
    EXPECT_EQ(back.height, 2u);
    EXPECT_EQ(back.viewpoint, cloud.viewpoint);
    EXPECT_EQ(back.rgb, rgb);
    expect_same_points(back.xyz, cloud.xyz);
  }
}

TEST_F(Io, WriterTakesPointsWithAStepAndCompresses) {
  std::vector<float> padded(4 * 5000, 0.0f);
  for (std::size_t i = 0; i < 5000; ++i) padded[4 * i + 2] = 1.5f, padded[4 * i + 3] = 1.0f;
  CloudView view;
  view.data = padded.data();
  view.point_step = 16;
  view.width = 5000;
  write_pcd(path("cloud.pcd"), view);
  EXPECT_LT(fs::file_size(path("cloud.pcd")), 5000u);
  const Cloud back = read_cloud(path("cloud.pcd"));
  ASSERT_EQ(back.size(), 5000u);
  EXPECT_EQ(back.xyz[3 * 4999 + 2], 1.5f);
  EXPECT_EQ(back.xyz[3 * 4999 + 1], 0.0f);
}

TEST_F(Io, WriterReplacesAtOnceAndLeavesNothingElse) {
  file("cloud.pcd", "old");
  write_pcd(path("cloud.pcd"), organized_cloud().view());
  EXPECT_EQ(read_cloud(path("cloud.pcd")).size(), 6u);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1);

  const std::string nowhere = path("no/such/folder.pcd");
  expect_error([&] { write_pcd(nowhere, organized_cloud().view()); }, nowhere, "cannot write");
  fs::create_directories(path("folder.pcd"));
  expect_error([&] { write_pcd(path("folder.pcd"), organized_cloud().view()); }, path("folder.pcd"), "cannot write");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 2);
  expect_error([&] { write_pcd("/dev/null", organized_cloud().view()); }, "/dev/null", "regular file");
  EXPECT_THROW(write_pcd(path("cloud.pcd"), organized_cloud().view(), {1, 2}), std::invalid_argument);
}

TEST_F(Io, EmptyCloudsComeBackEmpty) {
  write_pcd(path("empty.pcd"), Cloud().view());
  EXPECT_EQ(read_cloud(path("empty.pcd")).size(), 0u);
  EXPECT_EQ(read_cloud(file("a.pcd", xyz_header(0, 1, "ascii"))).size(), 0u);
  EXPECT_EQ(read_cloud(file("b.pcd", xyz_header(0, 0, "binary"))).size(), 0u);
  EXPECT_EQ(read_cloud(file("a.ply", ply_header("ascii", 0, kFloatXyz))).size(), 0u);
  EXPECT_EQ(read_cloud(file("b.ply", ply_header("binary_little_endian", 0, kFloatXyz))).size(), 0u);
}

TEST_F(Io, AsciiPcd) {
  const std::string data = "0.1 -0.2 0.7\nnan nan nan\n\n  1e-7\t2.5 -3.0  \r\n4 5 6\ninf 8 9\n-nan -2 +3\n";
  const Cloud cloud = read_cloud(file("cloud.pcd", xyz_header(3, 2, "ascii") + data));
  EXPECT_EQ(cloud.width, 3u);
  EXPECT_EQ(cloud.height, 2u);
  EXPECT_TRUE(cloud.rgb.empty());
  EXPECT_EQ(cloud.viewpoint, (Vector3{0.5, 0, -1}));  // the origin; the quaternion has no say
  expect_same_points(cloud.xyz, {0.1f, -0.2f, 0.7f, kNan, kNan, kNan, 1e-7f, 2.5f, -3.0f, 4, 5, 6,
                                 std::numeric_limits<float>::infinity(), 8, 9, kNan, -2, 3});
}

TEST_F(Io, BinaryPcdWithOtherFieldsAndPadding) {
  // label, x (double), padding of 3 bytes, y, z, histogram of 4, rgba, a 64-bit time stamp
  std::string bytes =
      pcd_header("label x _ y z h rgba t", "2 8 1 4 4 4 4 8", "U F U F F F U U", "1 1 3 1 1 4 1 1", 1, 2, "binary");
  for (int i = 0; i < 2; ++i) {
    bytes += raw<std::uint16_t>(7) + raw(0.1 + i) + "abc" + raw(2.0f + i) + raw(3.0f + i);
    for (int k = 0; k < 4; ++k) bytes += raw(99.0f);
    bytes += raw<std::uint32_t>(0xff102030u + i) + raw<std::uint64_t>(1);
  }
  const Cloud cloud = read_cloud(file("cloud.pcd", bytes));
  EXPECT_EQ(cloud.width, 1u);
  EXPECT_EQ(cloud.height, 2u);
  expect_same_points(cloud.xyz, {0.1f, 2, 3, 1.1f, 3, 4});
  EXPECT_EQ(cloud.rgb, (std::vector<std::uint32_t>{0x102030, 0x102031}));
}

TEST_F(Io, PcdBeforeVersion07) {
  const std::string bytes =
      "# .PCD v.5\nVERSION .5\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 2\nDATA ascii\n1 2 3\n4 5 6\n";
  const Cloud cloud = read_cloud(file("cloud.pcd", bytes));
  EXPECT_EQ(cloud.width, 2u);
  EXPECT_EQ(cloud.viewpoint, (Vector3{0, 0, 0}));
  expect_same_points(cloud.xyz, {1, 2, 3, 4, 5, 6});
}

TEST_F(Io, TheContentDecidesNotTheName) {
  EXPECT_EQ(read_cloud(file("cloud.ply", xyz_header(1, 1, "ascii") + "1 2 3\n")).size(), 1u);
  EXPECT_EQ(read_cloud(file("cloud.txt", ply_header("ascii", 1, kFloatXyz) + "1 2 3\n")).size(), 1u);
}

TEST_F(Io, AsciiPly) {
  const std::string header = ply_header("ascii", 2,
                                        "property double x\nproperty double y\nproperty double z\nproperty float nx\n"
                                        "property uchar blue\nproperty uchar green\nproperty uchar red\n"
                                        "element face 1\nproperty list uchar int vertex_indices\n");
  const Cloud cloud = read_cloud(file("cloud.ply", header + "0.1 2 3 0 3 2 1\nnan nan nan 0 0 0 255\n3 0 1 0\n"));
  EXPECT_EQ(cloud.width, 2u);
  EXPECT_EQ(cloud.height, 1u);
  expect_same_points(cloud.xyz, {0.1f, 2, 3, kNan, kNan, kNan});
  EXPECT_EQ(cloud.rgb, (std::vector<std::uint32_t>{0x010203, 0xff0000}));
}

TEST_F(Io, BinaryPlyInBothByteOrders) {
  for (const bool big : {false, true}) {
    std::string bytes = ply_header(big ? "binary_big_endian" : "binary_little_endian", 6, kFloatXyz);
    for (float value : kPoints) bytes += raw(value, big);
    expect_same_points(read_cloud(file("cloud.ply", bytes)).xyz, kPoints);
  }
}

TEST_F(Io, OrganizedPly) {
  // As PCL writes it with a camera ...
  std::string bytes = ply_header("ascii", 6,
                                 kFloatXyz +
                                     "element camera 1\nproperty float view_px\nproperty float view_py\n"
                                     "property float view_pz\nproperty int viewportx\nproperty int viewporty\n");
  for (int i = 0; i < 6; ++i) bytes += std::to_string(i) + " 0 1\n";
  const Cloud camera = read_cloud(file("camera.ply", bytes + "0.5 0.25 -1 3 2\n"));
  EXPECT_EQ(camera.width, 3u);
  EXPECT_EQ(camera.height, 2u);
  EXPECT_EQ(camera.viewpoint, (Vector3{0.5, 0.25, -1}));
  EXPECT_EQ(camera.xyz[15], 5.0f);

  // ... and without: only the points that were measured, and which pixel saw which.
  const auto grid = [](const std::string& second) {
    return "ply\nformat ascii 1.0\nobj_info num_cols 2\nobj_info num_rows 2\nelement vertex 2\n" + kFloatXyz +
           "element range_grid 4\nproperty list uchar int vertex_indices\nend_header\n1 2 3\n4 5 6\n0\n1 1\n0\n" +
           second;
  };
  const Cloud cloud = read_cloud(file("grid.ply", grid("1 0\n")));
  EXPECT_EQ(cloud.width, 2u);
  EXPECT_EQ(cloud.height, 2u);
  expect_same_points(cloud.xyz, {kNan, kNan, kNan, 4, 5, 6, kNan, kNan, kNan, 1, 2, 3});
  expect_unreadable(file("bad.ply", grid("1 2\n")), "vertex 2 of 2");
}

TEST_F(Io, WhatIsNoCloudIsRefused) {
  expect_unreadable(path("none.pcd"), "No such file");
  expect_unreadable(folder_.string(), "directory");
  expect_unreadable("/dev/null", "regular file");
  expect_unreadable(file("empty.pcd", ""), "empty");
  expect_unreadable(file("text.pcd", "hello\nworld\n"), "neither");
  expect_unreadable(file("image.pcd", "\x89PNG\r\n\x1a\n"), "PNG");
  expect_unreadable(file("comment.pcd", "# .PCD v0.7"), "without a line DATA");
  std::string garbage;
  std::uint32_t state = 1;
  for (int i = 0; i < 10000; ++i) garbage += static_cast<char>((state = state * 1664525u + 1013904223u) >> 24);
  expect_unreadable(file("garbage.pcd", garbage), "neither");
  expect_unreadable(file("garbage.ply", "ply\n" + garbage), "damaged");
}

TEST_F(Io, PcdHeadersThatContradictThemselvesAreRefused) {
  const auto header = [](const char* fields, const char* size, const char* type, const char* count) {
    return pcd_header(fields, size, type, count, 1, 1, "binary") + std::string(64, '\1');
  };
  expect_unreadable(file("a.pcd", header("x y", "4 4", "F F", "1 1")), "no field z");
  expect_unreadable(file("b.pcd", header("x y z", "4 4 4", "F I F", "1 1 1")), "field y holds integers");
  expect_unreadable(file("c.pcd", header("x y z", "4 4", "F F F", "1 1 1")), "SIZE has 2 entries");
  expect_unreadable(file("d.pcd", header("x y z", "4 4 3", "F F F", "1 1 1")), "SIZE 3");
  expect_unreadable(file("e.pcd", header("x y z", "4 4 4", "F F Q", "1 1 1")), "TYPE 'Q'");
  expect_unreadable(file("f.pcd", header("x y z", "4 4 4", "F F F", "1 1 0")), "COUNT 0");
  expect_unreadable(file("g.pcd", header("x y z", "4 4 4", "F F F", "1 1 -1")), "COUNT has no valid number '-1'");
  expect_unreadable(file("h.pcd", header("x y z f", "4 4 4 8", "F F F F", "1 1 1 1000000")), "over a megabyte");
  expect_unreadable(file("i.pcd", header("x y z", "4 4 4", "F F F", "2 1 1")), "COUNT above 1");
  expect_unreadable(file("j.pcd", header("x y z", "2 4 4", "F F F", "1 1 1")), "SIZE below 4");
  expect_unreadable(file("k.pcd",
                         "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2\nHEIGHT 2\nPOINTS 5\n"
                         "DATA ascii\n"),
                    "differs from POINTS 5");
  expect_unreadable(file("l.pcd", "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2\nHEIGHT 2\nDATA ascii\n"),
                    "no line POINTS");
  expect_unreadable(file("m.pcd", "VERSION 0.7\nFIELDS x y z\nFIELDS x y z\n"), "second line FIELDS");
  expect_unreadable(file("n.pcd", "VERSION 0.7\nPOINTS 5\nFIELDS x y z\n"), "after POINTS");
  expect_unreadable(file("o.pcd", "VERSION 0.7\nFIELDS x y z\nTYPE F F F\n"), "TYPE before SIZE");
  expect_unreadable(file("p.pcd", xyz_header(1, 1, "zipped")), "DATA 'zipped'");
  expect_unreadable(file("q.pcd", "VERSION 0.7\nVIEWPOINT 0 nan 0 1 0 0 0\n"), "VIEWPOINT 'nan'");
  expect_unreadable(file("r.pcd", "VERSION 0.7\nWIDTH 99999999999999999999\n"), "WIDTH has no valid number");
  const Cloud cloud = organized_cloud();
  write_pcd(path("s.pcd"), cloud.view());
  std::string padded = contents(path("s.pcd"));
  padded.replace(padded.find("x y z"), 5, "x _ y z").replace(padded.find("4 4 4"), 5, "4 4 4 4");
  padded.replace(padded.find("F F F"), 5, "F F F F").replace(padded.find("1 1 1"), 5, "1 1 1 1");
  expect_unreadable(file("s.pcd", padded), "padding");
}

TEST_F(Io, AbsurdSizesAreRefusedBeforeMemoryIsTaken) {
  for (const char* data : {"ascii", "binary", "binary_compressed"}) {
    const std::string bytes =
        "VERSION 0.7\nFIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nWIDTH 2147483647\nHEIGHT 1\nPOINTS 2147483647\nDATA " +
        std::string(data) + "\n1 2 3 4 5 6 7 8";
    expect_unreadable(file("cloud.pcd", bytes), "truncated");
  }
  expect_unreadable(file("wide.pcd",
                         "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2147483647\n"
                         "HEIGHT 2147483647\nPOINTS 1\nDATA binary\n"),
                    "differs");
  expect_unreadable(file("cloud.ply", "ply\nformat ascii 1.0\nelement vertex 18446744073709551615\n"), "promises");
  expect_unreadable(file("loop.ply", "ply\nformat ascii 1.0\nelement nothing 999999999999999\n" + kFloatXyz),
                    "promises");
}

TEST_F(Io, TruncatedDataAreRefused) {
  const std::string ascii = xyz_header(2, 1, "ascii");
  expect_unreadable(file("a.pcd", ascii), "truncated");
  expect_unreadable(file("b.pcd", ascii + "1.000000 2 3\n"), "1 points");
  expect_unreadable(file("c.pcd", ascii + "1.000000 2 3\n4 5\n"), "point 1 has 2 values");
  expect_unreadable(file("d.pcd", ascii + "1 2 3\n4 five 6\n"), "point 1 has no number as y");
  expect_unreadable(file("g.pcd", ascii + "1 2 3\n4 5 6 7\n"), "point 1 has 4 values");

  const std::string binary = xyz_header(2, 1, "binary");
  expect_unreadable(file("e.pcd", binary + std::string(23, '\0')), "23 bytes, the header promises 24");
  EXPECT_EQ(read_cloud(file("f.pcd", binary + std::string(24, '\0'))).size(), 2u);

  const std::string ply = ply_header("binary_little_endian", 2, kFloatXyz);
  expect_unreadable(file("a.ply", ply), "0 of 2 vertices");
  expect_unreadable(file("b.ply", ply + std::string(23, '\0')), "1 of 2 vertices");
  expect_unreadable(file("c.ply", ply_header("ascii", 2, kFloatXyz) + "1 2 3\n4 5\n"), "1 of 2 vertices");
}

TEST_F(Io, PlyHeadersWithoutACloudAreRefused) {
  expect_unreadable(file("a.ply",
                         "ply\nformat ascii 1.0\nelement face 0\nproperty list uchar int vertex_indices\n"
                         "end_header\n"),
                    "no element vertex");
  expect_unreadable(file("b.ply", ply_header("ascii", 1, "property float x\nproperty float y\n") + "1 2\n"), "no z");
  expect_unreadable(
      file("c.ply", ply_header("ascii", 1, "property int x\nproperty int y\nproperty int z\n") + "1 2 3\n"),
      "x holds integers");
  expect_unreadable(file("d.ply", "ply\nformat zipped 1.0\n"), "line 2");
}

// Whatever a byte is changed to, and wherever the file ends: a cloud or an IoError, nothing else.
TEST_F(Io, DamageNeverCrashes) {
  Cloud cloud;
  cloud.width = 16;
  cloud.height = 8;
  for (int i = 0; i < 16 * 8; ++i) {
    for (int k = 0; k < 3; ++k) cloud.xyz.push_back(0.001f * static_cast<float>(i % 7) + static_cast<float>(k));
  }
  write_pcd(path("cloud.pcd"), cloud.view(), std::vector<std::uint32_t>(cloud.size(), 0x203040));
  std::string ascii = xyz_header(16, 8, "ascii"), binary = xyz_header(16, 8, "binary");
  std::string ply =
      ply_header("binary_big_endian", 128,
                 kFloatXyz + "property uchar red\nproperty uchar green\n" + "property uchar blue\nelement face 1\n" +
                     "property list uint float vertex_indices\n");
  for (std::size_t i = 0; i < 128; ++i) {
    ascii += std::to_string(cloud.xyz[3 * i]) + " 1 nan\n";
    for (std::size_t k = 0; k < 3; ++k) binary += raw(cloud.xyz[3 * i + k]), ply += raw(cloud.xyz[3 * i + k], true);
    ply += "abc";
  }
  ply += raw<std::uint32_t>(1, true) + raw(0.0f);

  std::uint32_t state = 7;
  const auto next = [&] { return (state = state * 1664525u + 1013904223u) >> 8; };
  for (const std::string& whole : {contents(path("cloud.pcd")), ascii, binary, ply}) {
    ASSERT_EQ(read_cloud(file("whole", whole)).size(), 128u);
    int refused = 0;
    for (int round = 0; round < 200; ++round) {
      std::string bytes = whole;
      // The header is a small part of the file, but where most of the harm is done.
      const std::size_t reach = round % 2 ? bytes.size() : std::min<std::size_t>(bytes.size(), 250);
      for (std::uint32_t k = 0; k <= next() % 3; ++k) {
        bytes[next() % reach] = round % 3 ? static_cast<char>(next()) : static_cast<char>('0' + next() % 10);
      }
      if (round % 5 == 0) bytes.resize(next() % bytes.size());
      try {
        const Cloud back = read_cloud(file("damaged", bytes));
        EXPECT_EQ(back.xyz.size(), 3 * back.size());
        EXPECT_TRUE(back.rgb.empty() || back.rgb.size() == back.size());
      } catch (const IoError& error) {
        ++refused;
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
      }
    }
    EXPECT_GT(refused, 40);
  }
}

TEST_F(Io, NothingIsPrinted) {
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  EXPECT_THROW(read_cloud(file("a.ply", "ply\nformat zipped 1.0\n")), IoError);
  read_cloud(file(
      "b.pcd",
      "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n1 2 3\n4 5 6\n"));
  read_cloud(file("c.ply", ply_header("ascii", 1, kFloatXyz + "property ushort what\n") + "1 2 3 4\n"));
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

TEST_F(Io, ThreadsMayReadAtOnce) {
  write_pcd(path("cloud.pcd"), organized_cloud().view());
  std::vector<std::thread> threads;
  std::vector<int> read(4, 0);
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (int i = 0; i < 20; ++i) read[t] += static_cast<int>(read_cloud(path("cloud.pcd")).size());
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(read, std::vector<int>(4, 120));
}

// ---- depth images

void write_png(const std::string& path, int width, int height, int depth, int color, const std::string& rows,
               bool interlaced = false) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  ASSERT_NE(file, nullptr);
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_init_io(png, file);
  png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), depth, color,
               interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  png_set_interlace_handling(png);
  std::vector<png_bytep> pointers;
  std::string copy = rows;
  for (int v = 0; v < height; ++v) {
    pointers.push_back(reinterpret_cast<png_bytep>(copy.data()) + static_cast<std::size_t>(v) * (copy.size() / height));
  }
  png_write_image(png, pointers.data());
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  std::fclose(file);
}

std::uint32_t crc32(const std::string& bytes) {
  std::uint32_t crc = 0xffffffffu;
  for (const char byte : bytes) {
    crc ^= static_cast<unsigned char>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0u);
  }
  return ~crc;
}

std::string depth_rows(const std::vector<int>& values) {
  std::string bytes;
  for (int value : values) bytes += {static_cast<char>(value >> 8), static_cast<char>(value & 255)};
  return bytes;
}

TEST_F(Io, DepthImage) {
  for (const bool interlaced : {false, true}) {
    write_png(path("depth.png"), 3, 2, 16, PNG_COLOR_TYPE_GRAY, depth_rows({1000, 0, 2000, 500, 65535, 1}), interlaced);
    const Cloud cloud = read_depth_png(path("depth.png"), {500, 250, 1, 0.5}, 0.001);
    ASSERT_EQ(cloud.width, 3u);
    ASSERT_EQ(cloud.height, 2u);
    EXPECT_EQ(cloud.viewpoint, (Vector3{0, 0, 0}));
    expect_same_points({cloud.xyz.begin(), cloud.xyz.begin() + 12},
                       {-0.002f, -0.002f, 1, kNan, kNan, kNan, 0.004f, -0.004f, 2, -0.001f, 0.001f, 0.5f});
    EXPECT_FLOAT_EQ(cloud.xyz[14], 65.535f);
    EXPECT_FLOAT_EQ(cloud.xyz[17], 0.001f);
  }
}

TEST_F(Io, WhatIsNoDepthImageIsRefused) {
  const Intrinsics intrinsics{500, 500, 1, 1};
  const auto expect = [&](const std::string& name, const std::string& part) {
    expect_error([&] { read_depth_png(path(name), intrinsics, 0.001); }, path(name), part);
  };
  write_png(path("gray8.png"), 2, 2, 8, PNG_COLOR_TYPE_GRAY, std::string(4, '\1'));
  expect("gray8.png", "8-bit gray; 16-bit gray is needed");
  write_png(path("rgb.png"), 2, 2, 8, PNG_COLOR_TYPE_RGB, std::string(12, '\1'));
  expect("rgb.png", "8-bit colour");
  write_png(path("rgb16.png"), 2, 2, 16, PNG_COLOR_TYPE_RGB, std::string(24, '\1'));
  expect("rgb16.png", "16-bit colour");
  write_png(path("alpha.png"), 2, 2, 16, PNG_COLOR_TYPE_GRAY_ALPHA, std::string(16, '\1'));
  expect("alpha.png", "alpha");

  write_png(path("good.png"), 64, 64, 16, PNG_COLOR_TYPE_GRAY, std::string(64 * 64 * 2, '\3'));
  const std::string good = contents(path("good.png"));
  file("short.png", good.substr(0, good.size() - 20));
  expect("short.png", "truncated");
  file("head.png", good.substr(0, 20));
  expect("head.png", "libpng");
  std::string absurd = good;  // width and height stand at 16; libpng checks the header's CRC, which must stay right
  absurd.replace(16, 8, std::string("\0\x0f\x42\x40\0\x0f\x42\x40", 8));
  absurd.replace(29, 4, raw(crc32(absurd.substr(12, 17)), true));
  file("absurd.png", absurd);
  expect("absurd.png", "cannot stand in");
  file("text.png", "hello");
  expect("text.png", "no PNG");
  file("empty.png", "");
  expect("empty.png", "empty");
  expect("none.png", "No such file");

  EXPECT_EQ(read_depth_png(path("good.png"), intrinsics, 0.001).size(), 64u * 64u);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::string good_path = path("good.png");
  expect_error([&] { read_depth_png(good_path, {0, 500, 1, 1}, 0.001); }, good_path, "fx");
  expect_error([&] { read_depth_png(good_path, {500, -1, 1, 1}, 0.001); }, good_path, "fy");
  expect_error([&] { read_depth_png(good_path, {500, nan, 1, 1}, 0.001); }, good_path, "fy");
  expect_error([&] { read_depth_png(good_path, {500, 500, nan, 1}, 0.001); }, good_path, "cx");
  expect_error([&] { read_depth_png(good_path, intrinsics, 0); }, good_path, "unit");
}

}  // namespace
}  // namespace handhold
