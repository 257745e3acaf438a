# Installs BUILD into an empty PREFIX and checks that what REP-136, man and shells ask for is there.
file(REMOVE_RECURSE ${PREFIX})
execute_process(COMMAND ${CMAKE_COMMAND} --install ${BUILD} --prefix ${PREFIX} COMMAND_ERROR_IS_FATAL ANY
                OUTPUT_QUIET)
foreach(file share/pcl_gpu_icp/package.xml share/ament_index/resource_index/packages/pcl_gpu_icp
             include/pcl_gpu_icp/icp.h include/pcl_gpu_icp/version.h ${LIBDIR}/libpcl_gpu_icp.so
             ${LIBDIR}/pkgconfig/pcl_gpu_icp.pc share/doc/pcl_gpu_icp/samples/CMakeLists.txt
             share/man/man1/pcl_gpu_icp.1 share/bash-completion/completions/pcl_gpu_icp
             share/zsh/site-functions/_pcl_gpu_icp)
  if(NOT EXISTS ${PREFIX}/${file})
    message(FATAL_ERROR "the installed tree has no ${file}")
  endif()
endforeach()
