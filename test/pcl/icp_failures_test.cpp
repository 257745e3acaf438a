// What cannot be aligned: the error that is said and told by getResult(), and nothing left of the last alignment.
#include "icp_on_hills.h"

using pcl_gpu_icp::Reason;

using IcpFailures = IcpOnHills;

TEST_F(IcpFailures, AnAlignThatCannotStartClearsTheLastOne)
{
  struct Forgetful : Icp {
    void forgetSource() { this->input_.reset(); }
  } forgetful;
  alignWith(forgetful, source, target, twenty_iterations, identity);
  ASSERT_TRUE(forgetful.hasConverged());
  forgetful.forgetSource();
  Cloud output;
  forgetful.align(output);
  EXPECT_FALSE(forgetful.hasConverged());
  EXPECT_EQ(forgetful.getFinalTransformation(), identity);
  EXPECT_EQ(forgetful.getResult().reason, Reason::Error);
  EXPECT_NE(forgetful.getResult().message.find("there is no source"), std::string::npos);
}

TEST_F(IcpFailures, NoCloudAndAnEmptyOneAreErrorsThatSaySo)
{
  const auto outcomeOf = [](Icp& aligner) {
    Cloud output;
    aligner.align(output, scenes::smallMotion().matrix());
    EXPECT_FALSE(aligner.hasConverged());
    EXPECT_EQ(aligner.getFinalTransformation(), identity);
    EXPECT_EQ(aligner.getFitnessScore(), std::numeric_limits<double>::max());
    EXPECT_EQ(aligner.getResult().reason, Reason::Error);
    return aligner.getResult().message;
  };
  EXPECT_NE(outcomeOf(icp).find("there is no source"), std::string::npos);
  icp.setInputSource(source);
  EXPECT_NE(outcomeOf(icp).find("there is no target"), std::string::npos);
  // They do not leave an earlier cloud in place, either.
  for (const Cloud::Ptr& none : {Cloud::Ptr(), Cloud::Ptr(new Cloud)}) {
    icp.setInputSource(source);
    icp.setInputTarget(target);
    icp.setInputTarget(none);
    EXPECT_NE(outcomeOf(icp).find("there is no target"), std::string::npos);
    icp.setInputTarget(target);
    icp.setInputSource(none);
    EXPECT_NE(outcomeOf(icp).find("there is no source"), std::string::npos);
  }
  alignWith(icp, source, target, twenty_iterations, identity);
  EXPECT_TRUE(icp.hasConverged());
  EXPECT_EQ(icp.getResult().message, "");
}

TEST_F(IcpFailures, TooFewCorrespondencesSayWhy)
{
  const Cloud::Ptr all_nan(new Cloud(100, 1, PointXYZ(not_a_number, not_a_number, not_a_number)));
  const auto messageOf = [&](const Cloud::Ptr& from, const Cloud::Ptr& onto) {
    alignWith(
        icp, from, onto, [](auto& aligner) { aligner.setMaxCorrespondenceDistance(1e-9); }, identity);
    EXPECT_FALSE(icp.hasConverged());
    EXPECT_EQ(icp.getResult().reason, Reason::NoCorrespondences);
    return icp.getResult().message;
  };
  EXPECT_EQ(messageOf(all_nan, target), "No point of the source is finite.");
  EXPECT_EQ(messageOf(source, all_nan), "No point of the target is finite.");
  EXPECT_EQ(messageOf(source, target),
            "Not enough correspondences found: 0, where 3 are needed. Relax your threshold parameters.");
}

TEST_F(IcpFailures, IndicesOutsideTheSourceAreRefused)
{
  icp.setInputSource(source);
  icp.setInputTarget(target);
  for (const int index : {-1, int(source->size())}) {
    icp.setIndices(pcl::IndicesPtr(new pcl::Indices{0, 1, 2, index}));
    Cloud output;
    icp.align(output);
    EXPECT_FALSE(icp.hasConverged());
    EXPECT_EQ(icp.getResult().reason, Reason::Error);
    EXPECT_NE(icp.getResult().message.find("index " + std::to_string(index)), std::string::npos);
  }
}

TEST_F(IcpFailures, AFailureIsReportedAndNotThrown)
{
  struct FailingTree : pcl::search::KdTree<PointXYZ> {
    int nearestKSearch(const PointXYZ&, int, pcl::Indices&, std::vector<float>&) const override
    {
      throw std::runtime_error("the search is broken");
    }
    using pcl::search::KdTree<PointXYZ>::nearestKSearch;
  };
  Eigen::Matrix4f guess = identity;
  guess(0, 3) = 0.5F;
  icp.setInputSource(source);
  icp.setInputTarget(target);
  icp.setSearchMethodTarget(pcl::make_shared<FailingTree>());
  Cloud output;
  EXPECT_NO_THROW(icp.align(output, guess));
  EXPECT_FALSE(icp.hasConverged());
  EXPECT_EQ(icp.getFinalTransformation(), guess);
  EXPECT_EQ(icp.getResult().reason, Reason::Error);
  EXPECT_EQ(icp.getResult().message, "the search is broken");
  EXPECT_FLOAT_EQ(output[0].x, (*source)[0].x + 0.5F);
}
