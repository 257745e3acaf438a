// Clouds in the formats that people and other programs have them in.

#include "cli/cloud_file.h"
#include "cli/failure.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

using namespace pcl_gpu_icp;

namespace {

using Points = std::vector<std::array<double, 3>>;

const Points three = {{1, 2, 3}, {4.5, -5, 6e-3}, {7, 8, 9}};

Points pointsOf(const cli::Cloud& cloud) { return cli::coordinates(cloud, "a.xyz").points; }

cli::Cloud read(const std::string& content, const std::string& path = "a.xyz")
{
  return cli::parseCloud(path, content);
}

std::string refusal(const std::string& content, const std::string& path = "a.xyz")
{
  try {
    read(content, path);
  } catch (const cli::Failure& failure) {
    EXPECT_EQ(failure.code(), cli::ExitCode::Input);
    return failure.what();
  }
  return "none";
}

void expectIn(const std::string& part, const std::string& whole)
{
  EXPECT_NE(whole.find(part), std::string::npos) << "'" << part << "' is not in '" << whole << "'";
}

bool isDouble(const cli::Cloud& cloud) { return cli::coordinates(cloud, "a.xyz").from_double; }

} // namespace

TEST(TextCloud, IsReadAsProgramsAndPeopleWriteIt)
{
  Points expected = three;
  expected[1][2] = 6e-3F;
  for (const char* content : {
           "1 2 3\n4.5 -5 6e-3\n7 8 9\n",
           "1 2 3\n4.5 -5 6e-3\n7 8 9",
           "1\t2\t3\r\n4.5\t-5\t6e-3\r\n7\t8\t9\r\n",
           "1 2 3\r4.5 -5 6e-3\r7 8 9\r",
           "\xEF\xBB\xBF"
           "1,2,3\n4.5,-5,6e-3\n7,8,9\n",
           "1; 2; 3\n4.5 ;-5;6e-3\n7;8;9\n",
           "  1   2 3  \n\n \t4.5 \t -5 6e-3\n7 8 9",
           "# of a scanner\n1 2 3\n  // the second\n4.5 -5 6e-3\n#\n7 8 9\n \n",
           "+1 2. 3.000\n4.5e0 -5 0.006\n7 8 9\n",
           "x,y,z\n1,2,3\n4.5,-5,6e-3\n7,8,9\n",
           "\"X\", \"Y\", \"Z\"\n1,2,3\n4.5,-5,6e-3\n7,8,9\n",
           "X;Y;Z\n1;2;3\n4.5;-5;6e-3\n7;8;9\n",
           "x y z\n1 2 3\n4.5 -5 6e-3\n7 8 9\n",
           "x,y,z\n1 2 3\n4.5 -5 6e-3\n7 8 9\n",
           "//X Y Z\n1 2 3\n4.5 -5 6e-3\n7 8 9\n",
           // CloudCompare, with and without its count
           "//X Y Z R G B Scalar_field\n1 2 3 9 9 9 0.5\n4.5 -5 6e-3 9 9 9 nan\n7 8 9 9 9 9 0.1\n",
           "//X Y Z R G B\n3\n1 2 3 9 9 9\n4.5 -5 6e-3 9 9 9\n7 8 9 9 9 9\n",
           // a spreadsheet's columns, in its order and with labels
           "id,Z,name,X,Y\n1,3,a tree,1,2\n2,6e-3,,4.5,-5\n3,9,#house,7,8\n",
           // R
           "\"\",\"x\",\"y\",\"z\"\n\"1\",1,2,3\n\"2\",4.5,-5,6e-3\n\"3\",7,8,9\n",
           // PTS, in what it has behind x, y and z
           "3\n1 2 3 -900 10 20 30\n4.5 -5 6e-3 -900 10 20 30\n7 8 9 -900 10 20 30\n",
           "3\r\n1 2 3\r\n4.5 -5 6e-3\r\n7 8 9\r\n",
           "# PTS\n3\nx y z\n1 2 3\n4.5 -5 6e-3\n7 8 9\n",
       }) {
    const cli::Cloud cloud = read(content);
    EXPECT_EQ(pointsOf(cloud), expected) << content;
    EXPECT_EQ(cloud.warnings, cli::Warnings()) << content;
  }
  for (const char* path : {"a.txt", "a.csv", "a.ASC", "a.pts", "a", "a.dat"})
    EXPECT_EQ(pointsOf(read("1 2 3\n4.5 -5 6e-3\n7 8 9\n", path)), expected) << path;
}

TEST(TextCloud, SaysWhatItTookWhereThatWasGuessed)
{
  for (const char* content : {
           "1 2 3 0.5\n4 5 6 0.5\n",
           "1,2,3,tree\n4,5,6,\n",
           "# x y z\n1 2 3 0.5\n4 5 6 0.5\n", // which names fewer
           "# scanned on Monday\n1 2 3 0.5\n4 5 6 0.5\n",
       }) {
    const cli::Cloud cloud = read(content);
    EXPECT_EQ(pointsOf(cloud), (Points{{1, 2, 3}, {4, 5, 6}})) << content;
    EXPECT_EQ(cloud.warnings,
              cli::Warnings{"a.xyz: its 4 columns have no names; the first three are taken as x, y and z"})
        << content;
  }
}

TEST(TextCloud, RefusalsNameTheLine)
{
  const std::string decimal = "; its commas look like decimal commas: tr , . < a.xyz > NEW";
  EXPECT_EQ(refusal("1 2 3\n\n4 five 6\n"), "a.xyz: line 3: y: 'five' is not a number");
  EXPECT_EQ(refusal("1 2 3\r4 5 0x\r"), "a.xyz: line 2: z: '0x' is not a number");
  EXPECT_EQ(refusal("x,y,z\n1,,3\n"), "a.xyz: line 2: y is missing");
  EXPECT_EQ(refusal("name,y,z,x\na,2,3,1\nb,5,6,\n"), "a.xyz: line 3: x is missing");
  EXPECT_EQ(refusal("1 2 3\n4 5\n"), "a.xyz: line 2: has 2 columns where the lines before have 3");
  EXPECT_EQ(refusal("1 2 3\n4 5 6 7\n"), "a.xyz: line 2: has 4 columns where the lines before have 3");
  EXPECT_EQ(refusal("x y z\n1 2 3 4\n"), "a.xyz: line 2: has 4 columns where the lines before have 3");
  EXPECT_EQ(refusal("x,y,z\n1,2,3,4\n1,2,3,4\n"), "a.xyz: line 2: has 4 columns where the lines before have 3");
  EXPECT_EQ(refusal("1,2,3\n4 5 6\n"), "a.xyz: line 2: x: '4 5 6' is not a number");
  EXPECT_EQ(refusal("x,y,z,X\n1,2,3,4\n"), "a.xyz: line 1: names the column x twice");
  EXPECT_EQ(refusal("4\n1 2 3\n4 5 6\n"), "a.xyz: its first line promises 4 points; there are 2");
  EXPECT_EQ(refusal("1\n1 2 3\n4 5 6\n"), "a.xyz: its first line promises 1 points; there are 2");
  EXPECT_EQ(refusal("1 2 3\n2\n4 5 6\n"), "a.xyz: line 2: has 1 columns where the lines before have 3");
  EXPECT_EQ(refusal("X;Y;Z\n1,5;2,5;3,5\n"), "a.xyz: line 2: x: '1,5' is not a number" + decimal);
  EXPECT_EQ(refusal("x,y,z\n1,5,2,5,3,5\n"), "a.xyz: line 2: has 6 columns where the lines before have 3" + decimal);
  const std::string neither = "a.xyz: is not a PCD or PLY file, and for a text of points its line 1 has neither three "
                              "numbers nor the names x, y and z";
  EXPECT_EQ(refusal("hello\n"), neither + ": 'hello'");
  EXPECT_EQ(refusal("1 2\n3 4\n"), neither + ": '1 2'");
  EXPECT_EQ(refusal("north,east,up\n1,2,3\n"), neither + ": 'north,east,up'");
  EXPECT_EQ(refusal("C 1 2 3\n"), neither + ": 'C 1 2 3'");
  EXPECT_EQ(refusal("1,2 ; 3\n"), neither + ": '1,2 ; 3'");
  for (const char* content : {"1,5 2,5 3,5\n", "1,5\t2,5\t3,5\n", "1,5;2,5;3,5\n", "1 2,5 3\n", "1,5 2,5 3,5 9\n"})
    EXPECT_EQ(refusal(content), neither + decimal) << content;
  EXPECT_EQ(refusal("x y z\n"), "a.xyz: has no points");
  EXPECT_EQ(refusal("# nothing\n\n"), "a.xyz: has no points");
  EXPECT_EQ(refusal("0\n"), "a.xyz: has no points");
  EXPECT_LT(refusal("1 2 " + std::string(100000, 'x')).size(), 200U);
}

TEST(TextCloud, IsNotTakenForAPcdOrPlyFileThatLostItsHeader)
{
  for (const char* path : {"a.pcd", "a.PLY"})
    expectIn("is not a PCD or PLY file: it has neither the line FIELDS", refusal("1 2 3\n4 5 6\n", path));
}

TEST(TextCloud, HasPointsThatAreNotFinite)
{
  const Points points = pointsOf(read("1 2 3\nnan NaN -nan\n1.#QNAN inf none\n1e999 1 -inf\n"));
  ASSERT_EQ(points.size(), 4U);
  EXPECT_TRUE(std::isnan(points[1][2]));
  EXPECT_EQ(points[2][1], std::numeric_limits<double>::infinity());
  EXPECT_EQ(points[3][0], std::numeric_limits<double>::infinity());
}

TEST(TextCloud, IsDoubleWhereFloatWouldLoseDigits)
{
  const Points utm = {{512345.678, 5403210.987, 312.301}, {512346.679, 5403211.986, 312.302}, {512347, 5403212, 313}};
  const cli::Cloud far = read("512345.678 5403210.987 312.301\n512346.679 5403211.986 312.302\n512347 5403212 313\n"
                              "nan nan nan\n");
  EXPECT_TRUE(isDouble(far));
  Points points = pointsOf(far);
  points.pop_back();
  EXPECT_EQ(points, utm);
  EXPECT_FALSE(isDouble(read("100.5 200.25 3\n50 100 4\n0 0 0\n")));
  EXPECT_FALSE(isDouble(read("nan nan nan\n")));
}

namespace {

std::string bytesOf(const std::vector<float>& values)
{
  std::string bytes(values.size() * sizeof(float), '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

} // namespace

TEST(KittiScan, IsFourFloatsAPoint)
{
  const cli::Cloud cloud = read(bytesOf({1, 2, 3, 0, 4.5, -5, 6, 0.99F}), "a.BIN");
  EXPECT_EQ(pointsOf(cloud), (Points{{1, 2, 3}, {4.5, -5, 6}}));
  ASSERT_EQ(cloud.data.fields.size(), 4U);
  EXPECT_EQ(cloud.data.fields[3].name, "intensity");
  // Bytes that compressed files start with.
  float like_gzip = 0;
  std::memcpy(&like_gzip, "\x1F\x8B\x80\x3F", sizeof like_gzip);
  EXPECT_EQ(pointsOf(read(bytesOf({like_gzip, 2, 3, 0}), "a.bin"))[0][0], static_cast<double>(like_gzip));
}

TEST(KittiScan, RefusesWhatCanBeNone)
{
  expectIn("a.bin: its 20 bytes are no multiple of 16; a .bin file is read as a scan of KITTI",
           refusal(bytesOf({1, 2, 3, 0, 5}), "a.bin"));
  // nuScenes, whose fifth number is the ring
  expectIn("a.bin: point 3 has the intensity -2, and none is negative or not finite",
           refusal(bytesOf({1, 2, 3, 9, 0, 4, 5, 6, 7, 1, -1, -2, 3, 8, 2, 1, 2, 3, 9, 3}), "a.bin"));
  expectIn("has the intensity nan", refusal(bytesOf({0, 2, 3, NAN}), "a.bin"));
  // Text, whose bytes are small positive floats
  expectIn("a.bin: line 3: has 4 columns", refusal("1 2 3\n4 5 6\n7 8 9 10\n123456789", "a.bin"));
}

namespace {

/// Puts a value into the bytes of a file.
template <typename T>
void put(std::string& content, std::size_t place, T value)
{
  std::memcpy(&content[place], &value, sizeof value);
}

/// Two points, ten bytes longer than they must be: (100.5, -199.97, 3.25) and (100, -200, 3).
std::string las(unsigned minor, unsigned format, std::size_t record)
{
  const std::size_t header = minor < 4 ? 227 : 375, data = header + 54; // behind a record of variable length
  std::string content(data + 2 * (record + 10), '\0');
  content.replace(0, 4, "LASF");
  put<std::uint8_t>(content, 24, 1);
  put(content, 25, static_cast<std::uint8_t>(minor));
  put(content, 94, static_cast<std::uint16_t>(header));
  put(content, 96, static_cast<std::uint32_t>(data));
  put(content, 104, static_cast<std::uint8_t>(format));
  put(content, 105, static_cast<std::uint16_t>(record + 10));
  if (minor < 4)
    put<std::uint32_t>(content, 107, 2);
  else
    put<std::uint64_t>(content, 247, 2);
  const double scale[] = {0.5, 0.01, 0.25}, offset[] = {100, -200, 3};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    put(content, 131 + 8 * axis, scale[axis]);
    put(content, 155 + 8 * axis, offset[axis]);
  }
  const std::int32_t steps[] = {1, 3, 1};
  for (std::size_t axis = 0; axis < 3; ++axis)
    put(content, data + 4 * axis, steps[axis]);
  put<std::uint16_t>(content, data + 12, 65535);
  put<std::uint8_t>(content, data + (format < 6 ? 15 : 16), 6);
  return content;
}

template <typename T>
std::string lasRefusal(std::size_t place, T value)
{
  std::string content = las(2, 1, 28);
  put(content, place, value);
  return refusal(content, "a.las");
}

} // namespace

TEST(Las, PointsOfEveryFormatAreRead)
{
  const std::pair<unsigned, std::size_t> formats[] = {
      {0, 20}, {1, 28}, {2, 26}, {3, 34}, {4, 57}, {5, 63}, {6, 30}, {7, 36}, {8, 38}, {9, 59}, {10, 67}};
  for (const auto& [format, record] : formats)
    for (const unsigned minor : {0U, 2U, 4U}) {
      SCOPED_TRACE(std::to_string(format) + " in 1." + std::to_string(minor));
      const cli::Cloud cloud = read(las(minor, format, record), "a.las");
      EXPECT_EQ(pointsOf(cloud), (Points{{100.5, 3 * 0.01 - 200, 3.25}, {100, -200, 3}}));
      ASSERT_EQ(cloud.data.fields.size(), 5U);
      std::uint16_t intensity = 0;
      std::memcpy(&intensity, &cloud.data.data[cloud.data.fields[3].offset], sizeof intensity);
      EXPECT_EQ(intensity, 65535);
      EXPECT_EQ(cloud.data.data[cloud.data.fields[4].offset], 6);
      EXPECT_EQ(cloud.data.data[cloud.data.point_step + cloud.data.fields[4].offset], 0);
    }
}

TEST(Las, RefusesWhatCanBeNone)
{
  expectIn("a.las: its 4 bytes are fewer than the header of a LAS file has", refusal("LASF", "a.las"));
  expectIn("a.las: is a LAZ file, which is compressed: laspy decompress a.las (pip install 'laspy[cli,lazrs]')",
           lasRefusal<std::uint8_t>(104, 0x81));
  expectIn("has points of the format 11; 0 to 10 are read", lasRefusal<std::uint8_t>(104, 11));
  expectIn("says that a point of the format 1 has 27 bytes, and it has 28 at least",
           lasRefusal<std::uint16_t>(105, 27));
  expectIn("promises 3 points, and the file has 2", lasRefusal<std::uint32_t>(107, 3));
  expectIn("promises 2 points, and the file has 0", lasRefusal<std::uint32_t>(96, 4000000000));
  expectIn("promises 2 points, and the file has 0", lasRefusal<std::uint32_t>(96, 0));
  expectIn("the y of its points has the scale 0 and the offset -200", lasRefusal<double>(139, 0));
  expectIn("the z of its points has the scale 0.25 and the offset inf", lasRefusal<double>(171, INFINITY));
  expectIn("has no points", lasRefusal<std::uint32_t>(107, 0));
}

namespace {

std::string vtk(const std::string& points, const std::string& encoding = "ASCII", const std::string& set = "POLYDATA")
{
  return "# vtk DataFile Version 3.0\nany title\n" + encoding + "\nDATASET " + set + "\nPOINTS " + points;
}

std::string vtkRefusal(const std::string& content) { return refusal(content, "a.vtk"); }

} // namespace

TEST(Vtk, PointsAreRead)
{
  Points expected = three;
  for (const char* content :
       {"3 double\n1 2 3\n4.5 -5 6e-3\n7 8 9\n",
        "3 double\r\n1 2 3 4.5 -5 6e-3\r\n7 8 9",
        "3 double\n1 2 3\n4.5 -5 6e-3\n7 8 9\n\nMETADATA\nINFORMATION 0\n\nVERTICES 1 4\n3 0 1 2\n"})
    EXPECT_EQ(pointsOf(read(vtk(content), "a.vtk")), expected) << content;
  const char big_endian[] = "\x3F\x80\0\0\x40\0\0\0\xC0\x40\0\0";
  const std::string body(big_endian, sizeof big_endian - 1);
  for (const char* behind : {"", "\n", "\nVERTICES 1 2\n", "\r\nCELLS"})
    EXPECT_EQ(pointsOf(read(vtk("1 float\n" + body + behind, "BINARY", "UNSTRUCTURED_GRID"))), (Points{{1, 2, -3}}))
        << behind;
}

TEST(Vtk, RefusalsSayWhatIsWrong)
{
  expectIn("neither ASCII nor BINARY", vtkRefusal(vtk("1 float\n1 2 3\n", "XML")));
  expectIn("DATASET structured_points is not read", vtkRefusal(vtk("1 float\n1 2 3\n", "ASCII", "STRUCTURED_POINTS")));
  expectIn("POINTS of the type int are not read", vtkRefusal(vtk("1 int\n1 2 3\n")));
  expectIn("no whole number", vtkRefusal(vtk("many float\n1 2 3\n")));
  expectIn("has no points", vtkRefusal(vtk("0 float\n")));
  expectIn("point 2, y: 'five'", vtkRefusal(vtk("2 float\n1 2 3\n4 five 6\n")));
  const std::string promise = "its POINTS are not as many as the 2 that it promises";
  expectIn(promise, vtkRefusal(vtk("2 float\n1 2 3\n")));
  expectIn(promise, vtkRefusal(vtk("2 float\n1.25 2.25 3.25\n4.5 5.5\n")));
  expectIn(promise, vtkRefusal(vtk("2 float\n1 2 3\n4 5 6\n7 8 9\n")));
  expectIn(promise, vtkRefusal(vtk("2 float\n" + std::string(23, 'a'), "BINARY")));
  expectIn(promise, vtkRefusal(vtk("2 float\n" + std::string(24, 'a') + std::string(12, '\0'), "BINARY")));
  expectIn("has no POINTS",
           vtkRefusal("# vtk DataFile Version 3.0\n"
                      "title\nASCII\nDATASET POLYDATA\nFIELD FieldData 1\n"));
  expectIn("promises", vtkRefusal(vtk("100000000 double\n1 2 3\n")));
}
