#include "instances/instances.h"

PCL_GPU_ICP_GENERALIZED_INSTANCES(template class, pcl::PointXYZ)
