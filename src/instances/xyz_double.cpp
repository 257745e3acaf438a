#include "instances/instances.h"

PCL_GPU_ICP_POINT_INSTANCES(template class, pcl::PointXYZ, double)
