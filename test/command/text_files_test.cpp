// Numbers, manifests, guesses and results as people, spreadsheets and other programs write them.

#include "cli/batch_ledger.h"
#include "cli/cloud.h"
#include "cli/failure.h"
#include "cli/guess.h"
#include "cli/manifest.h"

#include "report/format.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <random>
#include <stdexcept>

using namespace pcl_gpu_icp;

namespace {

using Names = std::vector<std::pair<std::string, std::string>>;

std::vector<cli::ListedPair> manifest(const std::string& content, const std::string& path = "m.csv")
{
  cli::PairOptions options;
  return cli::parseManifest(path, content, {}, options);
}

Names namesOf(const std::vector<cli::ListedPair>& pairs)
{
  Names names;
  for (const auto& pair : pairs)
    names.emplace_back(pair.identity.source, pair.identity.target);
  return names;
}

/// The line that a call fails with.
template <typename Call>
std::string refusal(Call call)
{
  try {
    call();
  } catch (const cli::Failure& failure) {
    EXPECT_EQ(failure.code(), cli::ExitCode::Input);
    return failure.what();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "none";
}

std::string manifestRefusal(const std::string& content, const std::string& path = "m.csv")
{
  return refusal([&] { manifest(content, path); });
}

void expectIn(const std::string& part, const std::string& whole)
{
  EXPECT_NE(whole.find(part), std::string::npos) << "'" << part << "' is not in '" << whole << "'";
}

} // namespace

TEST(Csv, IsReadAsSpreadsheetsAndPeopleWriteIt)
{
  const Names one = {{"a.pcd", "b c.ply"}};
  for (const char* content : {
           "source,target\na.pcd,b c.ply\n",
           "source,target\na.pcd,b c.ply",
           "SOURCE,Target\r\na.pcd,b c.ply\r\n",
           "\xEF\xBB\xBFsource,target\r\na.pcd,b c.ply\r\n",
           "source, target\n a.pcd ,\tb c.ply \n",
           "source;target\r\na.pcd;b c.ply\r\n",
           "source\ttarget\na.pcd\tb c.ply\n",
           "source,target\ra.pcd,b c.ply\r",
           "source,target\na.pcd,b c.ply\n\n  \n",
           "source,target\na.pcd,b c.ply\n,\n",
           "\"source\", \"target\"\n \"a.pcd\" , \"b c.ply\" \n",
           "# pairs\nsource,target\n  # the first\na.pcd,b c.ply\n# the last",
           "\"source\";target\n\"a.pcd\";b c.ply\n",
       })
    EXPECT_EQ(namesOf(manifest(content)), one) << content;
  EXPECT_EQ(namesOf(manifest("source,target\na.pcd,b c.ply\n", "EXCEL.CSV")), one);
}

TEST(Csv, KeepsWhatIsQuoted)
{
  EXPECT_EQ(namesOf(manifest("source,target\n\" a \",\"b;\"\"c\"\"\n\"\n\"#x\",d;e\n")),
            (Names{{" a ", "b;\"c\"\n"}, {"#x", "d;e"}}));
  EXPECT_EQ(namesOf(manifest("source;target\na,b;c\n")), (Names{{"a,b", "c"}}));
  EXPECT_EQ(namesOf(manifest("source,target\n\xE9.pcd,b\n")), (Names{{"\xE9.pcd", "b"}}));
}

TEST(Csv, OptionsOfALine)
{
  const auto pairs = manifest("Source;Target;LEAF;Reciprocal;guess\n"
                              "a;b;0.50;TRUE;1 0 0 2 0 1 0 0 0 0 1 0\n"
                              "a;b;;False;[[1,0,0,2],[0,1,0,0],[0,0,1,0],[0,0,0,1]]\n");
  ASSERT_EQ(pairs.size(), 2U);
  EXPECT_EQ(pairs[0].identity.options,
            (cli::OptionTexts{{"guess", "1 0 0 2 0 1 0 0 0 0 1 0"}, {"leaf", "0.5"}, {"reciprocal", "true"}}));
  EXPECT_TRUE(pairs[0].alignment.reciprocal);
  EXPECT_FALSE(pairs[1].alignment.reciprocal);
  EXPECT_EQ(pairs[1].identity.options.at("guess"), "1 0 0 2 0 1 0 0 0 0 1 0 0 0 0 1");
}

TEST(Csv, RefusalsNameTheLine)
{
  EXPECT_EQ(manifestRefusal("source,Source,target\n"), "m.csv:1: has the column source twice");
  EXPECT_EQ(manifestRefusal("\n# c\nsource,target\r\na\r\n"), "m.csv:4: has 1 fields where the header has 2");
  EXPECT_EQ(manifestRefusal("source,target\ra\r"), "m.csv:2: has 1 fields where the header has 2");
  EXPECT_EQ(manifestRefusal("source,target\n\"a\r\nb\rc\",d\n\"e\" f,g\n"), "m.csv:5: text after a closing quote");
  EXPECT_EQ(manifestRefusal(std::string("source,target\na,b\0c\n", 20)),
            "m.csv:2: has a NUL byte; a manifest is text in UTF-8");
  EXPECT_EQ(manifestRefusal(std::string("\xFF\xFEs\0o\0", 6)), "m.csv:1: has a NUL byte; a manifest is text in UTF-8");
  expectIn("m.csv:2: leaf: 1e999", manifestRefusal("source,target,leaf\na,b,1e999\n"));
  expectIn("m.csv:2: reciprocal: maybe", manifestRefusal("source,target,reciprocal\na,b,maybe\n"));
  EXPECT_LT(manifestRefusal("source,target," + std::string(100000, 'x') + "\n").size(), 600U);
  EXPECT_EQ(manifestRefusal("source,target,\x1B\n").find('\x1B'), std::string::npos);
  EXPECT_EQ(manifestRefusal("source,target\n"), "m.csv: has no pairs");
}

TEST(JsonLines, AreReadWhateverTheCaseOfTheirKeys)
{
  const auto pairs =
      manifest("\xEF\xBB\xBF{\"source\":\"a\",\"target\":\"b\",\"guess\":[[1,0,0,0],[0,1,0,0],[0,0,1,0]]}\r\n\n"
               "{\"Source\":\"a\",\"TARGET\":\"b\",\"leaf\":null}",
               "m.JSONL");
  EXPECT_EQ(namesOf(pairs), (Names{{"a", "b"}, {"a", "b"}}));
  EXPECT_EQ(pairs[0].identity.options.at("guess"), "1 0 0 0 0 1 0 0 0 0 1 0");
}

TEST(JsonLines, RefusalsNameTheLine)
{
  const auto nested = [](const std::string& open, const std::string& close, int levels) {
    std::string text = "{\"source\":\"a\",\"target\":\"b\",\"guess\":";
    for (int i = 0; i < levels; ++i)
      text += open;
    text += "1";
    for (int i = 0; i < levels; ++i)
      text += close;
    return "{\"source\":\"a\",\"target\":\"b\"}\n" + text + "}\n";
  };
  for (const int levels : {40, 100000, 1000000}) {
    EXPECT_EQ(manifestRefusal(nested("[", "]", levels), "m.jsonl"), "m.jsonl:2: is nested deeper than 32 levels");
    EXPECT_EQ(manifestRefusal(nested("{\"a\":", "}", levels), "m.jsonl"), "m.jsonl:2: is nested deeper than 32 levels");
    EXPECT_EQ(manifestRefusal(std::string(levels, '['), "m.jsonl"), "m.jsonl:1: is nested deeper than 32 levels");
  }
  const std::string pair = "{\"source\":\"a\",\"target\":\"b\"";
  EXPECT_EQ(manifestRefusal(pair + ",\"source\":\"c\"}", "m.jsonl"), "m.jsonl:1: has source twice");
  EXPECT_EQ(manifestRefusal(pair + ",\"Source\":\"c\"}", "m.jsonl"), "m.jsonl:1: has source twice");
  EXPECT_EQ(manifestRefusal(pair + "}" + std::string(1, '\0') + "{", "m.jsonl"),
            "m.jsonl:1: has a NUL byte; a manifest is text in UTF-8");
  EXPECT_EQ(manifestRefusal("{\"source\":\"a\\u0000.pcd\",\"target\":\"b\"}", "m.jsonl"),
            "m.jsonl:1: source has a NUL character");
  expectIn("m.jsonl:1: is not JSON: ", manifestRefusal("{\"source\":\"\xFF\xFE\",\"target\":\"b\"}", "m.jsonl"));
  expectIn("m.jsonl:1: is not JSON: ", manifestRefusal(pair + ",\"leaf\":1e999}", "m.jsonl"));
  expectIn("m.jsonl:1: iterations: ", manifestRefusal(pair + ",\"iterations\":99999999999999999999}", "m.jsonl"));
  EXPECT_LT(manifestRefusal(pair + ",\"" + std::string(100000, 'x'), "m.jsonl").size(), 600U);
}

namespace {

std::string guessRefusal(const std::string& text)
{
  return refusal([&] { cli::parseGuess(text); });
}

} // namespace

TEST(Guess, IsReadAsProgramsPrintIt)
{
  const RigidTransform expected =
      cli::parseGuess("0.99026807 -0.13864415 0.0121297 0.004 0.1391731 0.98649813 -0.0863056 -0.003 "
                      "0 0.08715574 0.9961947 0.002 0 0 0 1");
  EXPECT_EQ(expected.translation, (std::array<double, 3>{0.004, -0.003, 0.002}));
  for (const char* text : {
           // KITTI
           "0.99026807 -0.13864415 0.0121297 0.004 0.1391731 0.98649813 -0.0863056 -0.003 0 0.08715574 0.9961947 0.002",
           // numpy
           "[[ 0.99026807 -0.13864415  0.0121297   0.004     ]\n [ 0.1391731   0.98649813 -0.0863056  -0.003     ]\n"
           " [ 0.          0.08715574  0.9961947   0.002     ]\n [ 0.          0.          0.          1.        ]]\n",
           "array([[ 0.99026807, -0.13864415,  0.0121297 ,  0.004     ],\n"
           "       [ 0.1391731 ,  0.98649813, -0.0863056 , -0.003     ],\n"
           "       [ 0.        ,  0.08715574,  0.9961947 ,  0.002     ],\n"
           "       [ 0.        ,  0.        ,  0.        ,  1.        ]], dtype=float32)",
           // MATLAB
           "[0.99026807, -0.13864415, 0.0121297, 0.004; 0.1391731, 0.98649813, -0.0863056, -0.003; "
           "0, 0.08715574, 0.9961947, 0.002; 0, 0, 0, 1]",
           // a spreadsheet
           "\xEF\xBB\xBF"
           "0.99026807;-0.13864415;0.0121297;0.004\r\n0.1391731;0.98649813;-0.0863056;-0.003\r\n"
           "0;0.08715574;0.9961947;0.002\r\n0;0;0;1\r\n",
           // a person
           "# scan 3 onto scan 2\n0.99026807 -0.13864415 0.0121297 0.004 # metres\n"
           "0.1391731 0.98649813 -0.0863056 -0.003\n\n0 0.08715574 0.9961947 0.002\n0 0 0 1",
           // a product of matrices
           "0.99026807 -0.13864415 0.0121297 0.004\n0.1391731 0.98649813 -0.0863056 -0.003\n"
           "0 0.08715574 0.9961947 0.002\n1e-17 -1e-9 0 1.0000001\n",
       }) {
    const RigidTransform guess = cli::parseGuess(text);
    EXPECT_EQ(guess.rotation, expected.rotation) << text;
    EXPECT_EQ(guess.translation, expected.translation) << text;
  }
}

TEST(Guess, IsReadAsAPositionAndAQuaternion)
{
  // 90 degrees about z; the quaternion's length is what three decimals leave.
  const RigidTransform guess = cli::parseGuess("0.1, 0.2, 0.3, 0, 0, 0.707, 0.707");
  const std::array<double, 9> expected{0, -1, 0, 1, 0, 0, 0, 0, 1};
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_NEAR(guess.rotation[i], expected[i], 1e-15);
  EXPECT_EQ(guess.translation, (std::array<double, 3>{0.1, 0.2, 0.3}));
}

TEST(Guess, AnyRotationMayHaveThreeDecimals)
{
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 10000; ++trial) {
    const Eigen::Quaterniond turn =
        Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random)).normalized();
    const Eigen::Matrix3d rotation = turn.toRotationMatrix();
    std::string matrix;
    for (int row = 0; row < 3; ++row)
      matrix += report::format("%.3f %.3f %.3f 0\n", rotation(row, 0), rotation(row, 1), rotation(row, 2));
    EXPECT_EQ(guessRefusal(matrix), "none") << matrix;
    const std::string pose = report::format("0 0 0 %.3f %.3f %.3f %.3f", turn.x(), turn.y(), turn.z(), turn.w());
    EXPECT_EQ(guessRefusal(pose), "none") << pose;
  }
}

TEST(Guess, RefusalsSayWhatItLooksLike)
{
  expectIn("it mirrors", guessRefusal("1 0 0 0 0 1 0 0 0 0 -1 0 0 0 0 1"));
  expectIn("it scales by 1.1", guessRefusal("1.1 0 0 0 0 1.1 0 0 0 0 1.1 0 0 0 0 1"));
  expectIn("it scales by 0.001 and mirrors", guessRefusal("1e-3 0 0 0 0 1e-3 0 0 0 0 -1e-3 0 0 0 0 1"));
  expectIn("it scales by 0", guessRefusal("0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 1"));
  expectIn("transposed", guessRefusal("1 0 0 0 0 1 0 0 0 0 1 0 0.004 -0.003 0.002 1"));
  expectIn("last row is 0 0 0 2, not 0 0 0 1", guessRefusal("1 0 0 5 0 1 0 0 0 0 1 0 0 0 0 2"));
  expectIn("0.0081 off", guessRefusal("0.99 -0.14 0.01 0.004 0.14 0.99 -0.09 -0.003 0.00 0.09 1.00 0.002 0 0 0 1"));
  expectIn("write more digits", guessRefusal("0.99 -0.14 0.01 0.004 0.14 0.99 -0.09 -0.003 0.00 0.09 1.00 0.002"));
  expectIn("too large", guessRefusal("1e308 1e308 0 0 1e308 -1e308 0 0 0 0 1 0 0 0 0 1"));
  expectIn("too large", guessRefusal("1e308 -1e308 1 0 1e308 1e308 -1 0 0 0 1e200 0"));
  expectIn("its quaternion (qx qy qz qw, the last four) has the length 2, not 1", guessRefusal("0 0 0 0 2 0 0"));
  expectIn("6 numbers where a 4x4 matrix has 16", guessRefusal("0.1 0.2 0.3 0 0 0"));
  expectIn("0 numbers where", guessRefusal("# nothing"));
  expectIn("'nan' is not a finite number", guessRefusal("nan 0 0 0 0 1 0 0 0 0 1 0"));
  expectIn("' ' is not a finite number", guessRefusal(std::string("\0 0 0", 5)));
}

TEST(Guess, NamesOfFilesAndNumbersAreToldApart)
{
  for (const char* text : {"1 0 0", "[[1, 0", " -1e3;2", "[ 1", "(1 0", "nan", "array([[1, 0", " np.array([1"})
    EXPECT_FALSE(cli::namesFile(text)) << text;
  for (const char* text : {"", "pose.txt", "[0]pose.txt", "(1).txt", "1.txt", "/tmp/1 2.txt", "array", "array.txt"})
    EXPECT_TRUE(cli::namesFile(text)) << text;
}

namespace {

std::string ledgerRefusal(const std::string& lines)
{
  std::vector<cli::ListedPair> pairs(2);
  pairs[0].identity = {0, "s", "t", {}};
  pairs[1].identity = {1, "s", "t", {}};
  return refusal([&] { cli::BatchLedger(pairs, "results.jsonl", lines); });
}

std::string resultLine(const std::string& pair = "0", const std::string& iterations = "3", const std::string& more = "")
{
  return "{\"pair\":" + pair +
         ",\"source\":\"s\",\"target\":\"t\",\"options\":{},\"status\":\"converged\",\"transform\":"
         "[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]],\"reason\":\"transform\",\"iterations\":" +
         iterations + ",\"rmse\":0.5,\"verdict\":\"good\",\"reasons\":[],\"quality\":null" + more + "}\n";
}

} // namespace

TEST(Results, LinesThatAreNoneAreNamed)
{
  EXPECT_EQ(ledgerRefusal(resultLine() + resultLine("1")), "none");
  const std::string good = resultLine();
  const std::string refused = "results.jsonl:2: is no result of a batch";
  for (const std::string& line : {resultLine("-1"),
                                  resultLine("0.5"),
                                  resultLine("1e30"),
                                  resultLine("true"),
                                  resultLine("1", "99999999999"),
                                  resultLine("1", "1e300"),
                                  resultLine("1", "-1"),
                                  resultLine("1", "3", ",\"pair\":1"),
                                  resultLine("1", "3", ",\"rmse\":1e999"),
                                  resultLine("1", "3", ",\"verdict\":\"fair\""),
                                  resultLine("1", "3", ",\"reasons\":[1]"),
                                  resultLine("1", "3", ",\"quality\":{}"),
                                  resultLine("1", "3", ",\"x\":\"\xFF\""),
                                  resultLine("1", "3", ",\"x\":" + std::string(50000, '[') + std::string(50000, ']')),
                                  std::string(100000, '[') + "\n",
                                  std::string("\0\n", 2),
                                  resultLine("1").substr(0, resultLine("1").size() - 1) + std::string("\0\n", 2),
                                  std::string("\n")})
    EXPECT_EQ(ledgerRefusal(good + line), refused) << line.substr(0, 300);
}

/// Read as a double, the shortest text of the greatest float is more than that.
TEST(Values, AFloatIsTheOneNearestToItsText)
{
  constexpr float greatest = std::numeric_limits<float>::max();
  const std::pair<const char*, float> values[] = {{"3.4028235e+38", greatest},
                                                  {"-3.4028235e+38", -greatest},
                                                  {"3.4028234663852886e+38", greatest},
                                                  {"3.5e38", std::numeric_limits<float>::infinity()},
                                                  {"1.17549435e-38", std::numeric_limits<float>::min()},
                                                  {"1e-45", std::numeric_limits<float>::denorm_min()},
                                                  // Halfway but for what a double does not hold.
                                                  {"1.00000017881393432617187499", 1.00000011920928955F},
                                                  {"1.00000017881393432617187501", 1.00000023841857910F}};
  for (const auto& [text, value] : values) {
    std::uint8_t place[sizeof(float)] = {};
    EXPECT_EQ(cli::storeNumber(text, pcl::PCLPointField::FLOAT32, place), cli::Stored::Exactly) << text;
    float stored = 0;
    std::memcpy(&stored, place, sizeof stored);
    EXPECT_EQ(stored, value) << text;
  }
}
