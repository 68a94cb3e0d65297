"""What gives a Clip of files: data sets, images, videos. renderer.layouts knows them all."""
