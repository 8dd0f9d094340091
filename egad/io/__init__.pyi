from .content import Content as Content
from .gltf import TO_Y_UP as TO_Y_UP
from .mesh import ENDINGS as ENDINGS
from .mesh import read_content as read_content
from .mesh import read_mesh as read_mesh
from .plain_obj import obj_text as obj_text
from .units import ALLOWED as ALLOWED
from .units import METRES as METRES
