# Builds SOURCE with COLCON in an empty WORKSPACE, as a ROS 2 user does but without optimising, which takes half as long,
# and runs the command that it installs.
file(REMOVE_RECURSE ${WORKSPACE})
file(MAKE_DIRECTORY ${WORKSPACE}/src)
file(CREATE_LINK ${SOURCE} ${WORKSPACE}/src/pcl_gpu_icp SYMBOLIC)
execute_process(
  COMMAND ${COLCON} build --paths src/pcl_gpu_icp --event-handlers console_direct+ --cmake-args -DCMAKE_BUILD_TYPE=None
  WORKING_DIRECTORY ${WORKSPACE} COMMAND_ERROR_IS_FATAL ANY)

set(installed ${WORKSPACE}/install/pcl_gpu_icp)
foreach(file share/pcl_gpu_icp/package.xml share/ament_index/resource_index/packages/pcl_gpu_icp)
  if(NOT EXISTS ${installed}/${file})
    message(FATAL_ERROR "the workspace has no ${file}")
  endif()
endforeach()
execute_process(COMMAND ${installed}/bin/pcl_gpu_icp --version WORKING_DIRECTORY / COMMAND_ERROR_IS_FATAL ANY)
