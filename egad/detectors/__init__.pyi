from .base import Detector as Detector
from .base import Grasp as Grasp
from .ggcnn import GGCNN as GGCNN
