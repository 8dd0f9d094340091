from .forest import Forest as Forest
from .graph import extract as extract
from .neighbors import Neighborhood as Neighborhood
from .neighbors import diversities as diversities
from .parameters import Bases as Bases
from .parameters import Similarity as Similarity
from .similarity import similarities as similarities
from .similarity import similarity_matrix as similarity_matrix
